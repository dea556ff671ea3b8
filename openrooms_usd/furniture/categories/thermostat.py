"""Thermostats on a wall."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import facing
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import cylinder


def dial(size: Size, rng: np.random.Generator) -> Parts:
    """A round one whose ring turns about a dark glass."""
    radius, y, middle = 0.5 * size[0], 0.5 * size[1], 0.5 * size[2]
    return {
        "body": facing(cylinder(radius, size[1] - 0.003, bevel=0.003, segments=24), (0, y, middle)),
        "screen": facing(
            cylinder(0.72 * radius, size[1] - 0.002, bevel=0.001, segments=28),
            (0, y - 0.002, middle),
        ),
    }


def box(size: Size, rng: np.random.Generator) -> Parts:
    """A flat box with a small display and two keys."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    keys = board((-0.5 * x, -y, 0.2 * height), (0.5 * x, 0.0, 0.32 * height), 0.001)
    return {
        "body": board((-x, -y + 0.002, 0.0), (x, y, height), 0.004),
        "screen": board((-0.6 * x, -y + 0.001, 0.5 * height), (0.6 * x, 0.0, 0.82 * height), 0.0),
        "button": keys,
    }


CATEGORY: Final = BuiltCategory(
    description="a thermostat on a wall",
    size=(0.09, 0.026, 0.12),
    min_size=(0.05, 0.015, 0.05),
    max_size=(0.2, 0.08, 0.2),
    styles={
        "dial": Style(dial, lambda size: abs(size[0] - size[2]) < 0.01, (0.084, 0.03, 0.084)),
        "box": Style(box),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="wall",
    mount_height=1.4,
    fixed=True,
    words="thermostat_control",
    schemes=(
        scheme("plastic", screen="screen", plastic="button", weight=2.0),
        scheme("steel", screen="screen", plastic="button"),
    ),
    construction=(row(ANY, filled(900), "common"),),
)
