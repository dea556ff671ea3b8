"""Photographs in frames that stand on a strut."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.boards import SIDE, profiled, strip
from openrooms_usd.furniture.joinery.paintings import landscape, skyline
from openrooms_usd.furniture.joinery.pieces import Build, Furniture, Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.joinery.wall_board import framed_as
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import METAL, landscape_print, scheme

_LEAN_DEG: Final = 12.0
_PORTRAIT: Final = framed_as(landscape, (0.02, 0.1))
_TOWN: Final = framed_as(skyline, (0.02, 0.1))


def standing(size: Size, rng: np.random.Generator, *, build: Build) -> Parts:
    """A frame that leans back, and the strut behind it."""
    width, depth, height = size
    c, s = np.cos(np.radians(_LEAN_DEG)), np.sin(np.radians(_LEAN_DEG))
    thick = 0.016
    tall = (height - thick * s) / c
    made = build((width, thick, tall), rng)
    parts = made.parts if isinstance(made, Furniture) else made
    front = -0.5 * depth + 0.5 * thick * c
    leaning = {name: turned(mesh, "x", -_LEAN_DEG) for name, mesh in parts.items()}
    low = min(mesh.extent[0][2] for mesh in leaning.values())
    stood = {name: mesh.moved((0.0, front, -low)) for name, mesh in leaning.items()}
    head = (front + 0.55 * height * s / c + 0.4 * thick, 0.55 * height)
    line = np.array([head, (0.5 * depth - 0.002, 0.002)])
    strut = profiled(strip(line, 0.004), 0.3 * width, SIDE, 0.0)
    return {**stood, "stand": strut.moved((0.0, 0.0, -strut.extent[0][2]))}


CATEGORY: Final = BuiltCategory(
    description="a photograph in a standing frame",
    size=(0.2, 0.1, 0.15),
    min_size=(0.06, 0.04, 0.06),
    max_size=(0.5, 0.3, 0.5),
    styles={
        "wide": Style(partial(standing, build=_PORTRAIT), lambda size: size[0] > size[2]),
        "upright": Style(
            partial(standing, build=_TOWN), lambda size: size[0] <= size[2], (0.15, 0.12, 0.2)
        ),
    },
    size_variation=WIDE,
    max_per_room=6,
    support="surface",
    mass_range=(0.1, 1.2),
    words="photo_frames standing_frame framed_photo",
    classes=Classes(nyu40="picture", ade20k="painting"),
    schemes=tuple(
        scheme(frame, landscape_print(tones), white_paper="mat")
        for tones, frame in (
            ("dawn", "wood"),
            ("silver", "black"),
            ("meadow", "white"),
            ("silver", METAL),
        )
    ),
    construction=(row(ANY, solid(700), "common"),),
    placements=(
        on(
            "cabinet_top dresser_top mantel shelf media_top",
            weight=0.5,
            count=(1, 3),
            max_variants=6,
            max_groups=3,
        ),
        on("bedside desk side_table window_sill", weight=0.3, max_variants=6, max_groups=1),
    ),
)
