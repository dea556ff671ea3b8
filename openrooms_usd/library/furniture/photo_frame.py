"""Photographs in frames that stand on a strut."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import METAL, TONES, Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    WIDE,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import (
    SIDE,
    Build,
    Furniture,
    Parts,
    Size,
    Style,
    profiled,
    strip,
)
from openrooms_usd.library.furniture.lying import Lies
from openrooms_usd.library.furniture.paintings import landscape, skyline
from openrooms_usd.library.furniture.posing import turned
from openrooms_usd.library.furniture.wall_board import framed_as

_LEAN_DEG: Final = 12.0
_PORTRAIT: Final = framed_as(landscape, (0.02, 0.1))
_TOWN: Final = framed_as(skyline, (0.02, 0.1))


def _standing(build: Build, size: Size, rng: np.random.Generator) -> Parts:
    """A frame that leans back, and the strut behind it."""
    width, depth, height = size
    c, s = np.cos(np.radians(_LEAN_DEG)), np.sin(np.radians(_LEAN_DEG))
    thick = 0.016
    tall = (height - thick * s) / c
    made = build((width, thick, tall), rng)
    parts = made.parts if isinstance(made, Furniture) else made
    front = -0.5 * depth + 0.5 * thick * c
    stood = {name: turned(mesh, "x", -_LEAN_DEG).moved((0.0, front, 0.5 * thick * s))
             for name, mesh in parts.items()}  # fmt: skip
    head = (front + 0.55 * height * s / c + 0.4 * thick, 0.55 * height)
    line = np.array([head, (0.5 * depth - 0.002, 0.002)])
    strut = profiled(strip(line, 0.004), 0.3 * width, SIDE, 0.0)
    return {**stood, "stand": strut}


def landscape_format(size: Size, rng: np.random.Generator) -> Parts:
    """A photograph that is wider than high."""
    return _standing(_PORTRAIT, size, rng)


def upright_format(size: Size, rng: np.random.Generator) -> Parts:
    """A photograph that is higher than wide."""
    return _standing(_TOWN, size, rng)


CATEGORY: Final = BuiltCategory(
    description="a photograph in a standing frame",
    size=(0.2, 0.1, 0.15),
    least=(0.06, 0.04, 0.06),
    most=(0.5, 0.3, 0.5),
    styles={
        "wide": Style(landscape_format, lambda size: size[0] > size[2]),
        "upright": Style(upright_format, lambda size: size[0] <= size[2], (0.15, 0.12, 0.2)),
    },
    spread=WIDE,
    round=False,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.1, 1.2)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="photo_frames standing_frame framed_photo",
    classes=Classes(UNLABELED, "picture", "painting", UNLABELED),
    synsets=NO_SYNSET,
    schemes=tuple(
        Scheme(
            {
                ANY: frame,
                "mat": "white_paper",
                "canvas": f"{name}_sky",
                **{tone: f"{name}_{tone}" for tone in TONES if tone != "sky"},
            }
        )
        for name, frame in (
            ("dawn", "wood"),
            ("silver", "black"),
            ("meadow", "white"),
            ("silver", METAL),
        )
    ),
    makes=(makes.row(ANY, makes.solid(700), "common"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(
            on=("cabinet_top", "dresser_top", "mantel", "shelf", "media_top"),
            weight=0.5,
            count=(1, 3),
            makes=6,
            most=3,
        ),
        Lies(on=("bedside", "desk", "side_table", "window_sill"), weight=0.3, most=1),
    ),
)
