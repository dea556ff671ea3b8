"""Boxes of tissues, one of which stands out of the slot."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.sweeps import extrude, sheet


def _tissue(wide: float, deep: float, tall: float, rng: np.random.Generator) -> Mesh:
    """A tuft of thin paper that rises from the origin."""
    u, v = np.meshgrid(np.linspace(-1.0, 1.0, 11), np.linspace(0.0, 1.0, 6))
    open_ = 0.35 + 0.65 * v
    x = 0.5 * wide * u * open_
    y = 0.5 * deep * np.sin(2.2 * u + float(rng.uniform(0.0, 3.0))) * v**0.8
    z = tall * v * (1.0 - 0.3 * np.abs(u) ** 1.5)
    return sheet(np.stack([x, y, z], axis=-1), 0.0006)


def _box(size: Size, card: float, rng: np.random.Generator) -> Parts:
    width, depth, height = size
    x, y = 0.5 * width, 0.5 * depth
    slot = extrude(
        superellipse(0.5 * width, 0.3 * min(width, depth), 2.0, 24), 0.0006, base=card - 0.0003
    )
    tuft = _tissue(0.42 * width, 0.4 * depth, height - card + 0.004, rng)
    return {
        "box": board((-x, -y, 0.0), (x, y, card), 0.0012),
        "slot": slot,
        "paper": tuft.moved((0.0, 0.0, card - 0.004)),
    }


def flat(size: Size, rng: np.random.Generator) -> Parts:
    """A long low box."""
    return _box(size, 0.6 * size[2], rng)


def cube(size: Size, rng: np.random.Generator) -> Parts:
    """A box as high as it is wide."""
    return _box(size, 0.7 * size[2], rng)


CATEGORY: Final = BuiltCategory(
    description="a box of paper tissues",
    size=(0.23, 0.12, 0.115),
    min_size=(0.08, 0.06, 0.05),
    max_size=(0.4, 0.3, 0.3),
    styles={
        "flat": Style(flat, lambda size: size[0] > 1.3 * size[1]),
        "cube": Style(cube, lambda size: size[0] <= 1.3 * size[1], (0.12, 0.12, 0.18)),
    },
    size_variation=STANDARD,
    max_per_room=1,
    support="surface",
    mass_range=(0.1, 0.6),
    words="tissue tissues kleenex kleenex_box",
    classes=Classes(nyu40="box", ade20k="box"),
    schemes=(
        scheme("package_field", tissue="paper", cavity="slot", weight=2.0),
        scheme("wood", tissue="paper", cavity="slot"),
    ),
    construction=(row("box", filled(130), "weight"), row(ANY, filled(200), "common")),
    placements=(
        on("bedside coffee_table side_table desk", weight=0.45, max_groups=1),
        on("cistern basin_edge cabinet_top", "bathroom", weight=0.4, max_groups=1),
    ),
)
