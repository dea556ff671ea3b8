"""Thermostats on a wall."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.library.furniture.built import (
    NEVER_WEIGHED,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, board
from openrooms_usd.library.furniture.posing import facing


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


STYLES: Final = {
    "dial": Style(dial, lambda size: abs(size[0] - size[2]) < 0.01, (0.084, 0.03, 0.084)),
    "box": Style(box),
}


CATEGORY: Final = BuiltCategory(
    description="a thermostat on a wall",
    size=(0.09, 0.026, 0.12),
    least=(0.05, 0.015, 0.05),
    most=(0.2, 0.08, 0.2),
    styles=STYLES,
    spread=STANDARD,
    round=False,
    alike=True,
    support="wall",
    also=(),
    level=1.4,
    lumen=NO_LAMP,
    weighs=NEVER_WEIGHED,
    worktop=NO_APPLIANCE,
    fixed=True,
    words="thermostat_control",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "plastic", "screen": "screen", "button": "plastic"}, weight=2.0),
        Scheme({ANY: "steel", "screen": "screen", "button": "plastic"}),
    ),
    makes=(makes.row(ANY, makes.filled(900), "common"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
