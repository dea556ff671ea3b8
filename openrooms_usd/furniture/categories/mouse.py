"""Mice of computers, with and without a cable."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric


def wireless(size: Size, rng: np.random.Generator) -> Parts:
    """The body, its wheel and the groove between its two keys; the keys to the back."""
    width, depth, height = size
    outline = superellipse(1.0, 1.0, 2.6, 26)
    crest = float(rng.uniform(-0.05, 0.03))
    rows = [
        (0.9, 0.0, 0.0),
        (1.0, 0.12, 0.0),
        (0.99, 0.4, 0.0),
        (0.88, 0.72, crest),
        (0.66, 0.92, 1.6 * crest),
        (0.3, 1.0, 2.0 * crest),
    ]
    rings = [
        ring(outline * [a * width, a * depth] + [0.0, shift * depth], z * height)
        for a, z, shift in rows
    ]
    body = metric(loft(rings, crease=60.0))[0]
    wheel = turned(cylinder(0.012, 0.006, bevel=0.001, segments=16, base=(0, 0, -0.003)), "y", 90.0)
    groove = board(
        (-0.0006, 0.12 * depth, 0.55 * height), (0.0006, 0.42 * depth, 0.8 * height), 0.0002
    )
    return {
        "body": body,
        "wheel": wheel.moved((0.0, 0.28 * depth, 0.62 * height)),
        "groove": groove,
    }


def wired(size: Size, rng: np.random.Generator) -> Parts:
    """A mouse with a cable that runs off to the back."""
    width, depth, height = size
    body = min(0.115, 0.6 * depth)
    parts = wireless((min(width, 0.064), body, height), rng)
    shift = 0.5 * body - 0.5 * depth
    bend = float(rng.choice([-1.0, 1.0])) * (width - 0.5 * min(width, 0.064) - 0.0018)
    t = np.linspace(0.0, 1.0, 13)
    y = shift + 0.48 * body + (0.5 * depth - shift - 0.48 * body) * t
    x = bend * np.sin(np.pi * t) ** 2
    z = 0.002 + 0.008 * (1.0 - t) ** 3
    cable = tube(np.stack([x, y, z], axis=1), 0.0018, segments=6)
    moved = {name: mesh.moved((0.0, shift, 0.0)) for name, mesh in parts.items()}
    return {**moved, "cable": cable}


CATEGORY: Final = BuiltCategory(
    description="the mouse of a computer",
    size=(0.064, 0.115, 0.038),
    min_size=(0.03, 0.06, 0.02),
    max_size=(0.12, 0.4, 0.08),
    styles={
        "wireless": Style(wireless),
        "wired": Style(wired, lambda size: size[1] > 2.4 * size[0], (0.075, 0.26, 0.038)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="surface",
    mass_range=(0.05, 0.2),
    words="computer_mouse",
    classes=Classes(coco="mouse"),
    schemes=(
        scheme("black_plastic", membrane="wheel", cavity="groove", weight=2.0),
        scheme("plastic", grey="wheel groove"),
    ),
    construction=(row(ANY, filled(650), "weight"),),
    placements=(on("desk", weight=0.9, cluster="computer", max_groups=1),),
)
