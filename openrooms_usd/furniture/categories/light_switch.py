"""Switches beside doors."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board, wall_plate
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined


def _rocker(size: Size, x: float, width: float, rng: np.random.Generator) -> Mesh:
    """A key that is tipped to one of its two sides."""
    front, middle = -0.5 * size[1] + 0.001, 0.5 * size[2]
    tall = 0.68 * size[2]
    key = board(
        (x - 0.5 * width, front, middle - 0.5 * tall),
        (x + 0.5 * width, front + 0.006, middle + 0.5 * tall),
        0.001,
    )
    tip = float(rng.choice([-1.0, 1.0])) * 2.2
    return turned(key, "x", tip, (0.0, front + 0.0025, middle))


def rocker(size: Size, rng: np.random.Generator) -> Parts:
    """One wide key."""
    return {"cover": wall_plate(size, 0.008), "switch": _rocker(size, 0.0, 0.68 * size[0], rng)}


def twin(size: Size, rng: np.random.Generator) -> Parts:
    """Two narrow keys."""
    wide = 0.33 * size[0]
    keys = [_rocker(size, s * 0.52 * wide, wide, rng) for s in (-1.0, 1.0)]
    return {"cover": wall_plate(size, 0.008), "switch": joined(keys)}


def toggle(size: Size, rng: np.random.Generator) -> Parts:
    """A short lever in a plate of metal."""
    y, middle = 0.5 * size[1], 0.5 * size[2]
    lever = board((-0.004, -y + 0.0005, middle - 0.005), (0.004, y - 0.004, middle + 0.005), 0.001)
    tip = float(rng.choice([-1.0, 1.0])) * 20.0
    return {
        "cover": wall_plate(size, 0.006),
        "switch": turned(lever, "x", tip, (0.0, y - 0.005, middle)),
    }


CATEGORY: Final = BuiltCategory(
    description="a switch for lamps beside a door",
    size=(0.082, 0.014, 0.082),
    min_size=(0.05, 0.01, 0.05),
    max_size=(0.3, 0.04, 0.2),
    styles={
        "rocker": Style(rocker, lambda size: size[2] < 1.3 * size[0]),
        "twin": Style(twin, lambda size: size[2] < 1.3 * size[0]),
        "toggle": Style(toggle, lambda size: size[2] > 1.3 * size[0], (0.07, 0.024, 0.115)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="wall",
    mount_height=1.05,
    fixed=True,
    words="wall_switch dimmer",
    schemes=(
        scheme("plastic", weight=3.0),
        scheme("plastic", steel="cover"),
        scheme("plastic", brass="cover"),
    ),
    construction=(row(ANY, filled(900), "common"),),
)
