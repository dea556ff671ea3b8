"""Backpacks that stand on their base: a soft body, a front pocket, straps and a loop."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.solids import cushion
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, board, numbered
from openrooms_usd.library.furniture.lying import Lies
from openrooms_usd.library.furniture.posing import tapered

_DRY: Final = (
    "living_room", "bedroom", "office", "hallway", "apartment", "classroom", "library", "hotel",
    "computer_cluster", "game_room", "gym", "lounge", "conference_room", "closet",
)  # fmt: skip


def day(size: Size, rng: np.random.Generator) -> Parts:
    """A school or city backpack, narrower above."""
    width, depth, height = size
    back, strap = 0.5 * depth, 0.02
    deep = 0.72 * depth
    high = height - 0.03
    body = tapered(cushion((1.056 * width, deep, high), radius=0.05, crown=(0.012, 0.02, 0.01),
                           center=(0.0, back - strap - 0.5 * deep, 0.5 * high)), "z",
                   (0.86, 0.72))  # fmt: skip
    pocket = cushion((0.74 * width, 0.4 * depth, 0.42 * height), radius=0.03,
                     crown=(0.006, 0.012, 0.008),
                     center=(0.0, -back + 0.2 * depth, 0.06 + 0.21 * height))  # fmt: skip
    straps = [
        tube(filleted([(s * 0.3 * width, back - strap, 0.08 * height),
                       (s * 0.34 * width, back - 0.006, 0.4 * height),
                       (s * 0.16 * width, back - 0.006, 0.8 * height),
                       (s * 0.12 * width, back - strap - 0.04, 0.9 * height)], 0.04, segments=4),
             0.006, segments=8) for s in (-1.0, 1.0)
    ]  # fmt: skip
    y = back - strap - 0.3 * deep
    loop = tube(filleted([(-0.04, y, high - 0.02), (-0.03, y, height - 0.006),
                          (0.03, y, height - 0.006), (0.04, y, high - 0.02)], 0.012), 0.006,
                segments=8)  # fmt: skip
    zips = [board((-0.3 * width, -back + 0.001, 0.07 + 0.34 * height),
                  (0.3 * width, -back + 0.03, 0.076 + 0.34 * height), 0.001)]  # fmt: skip
    return {"bag": body, "pocket": pocket, **numbered("strap", [*straps, loop]),
            **numbered("lock", zips)}  # fmt: skip


CATEGORY: Final = BuiltCategory(
    description="a backpack",
    size=(0.32, 0.24, 0.46),
    least=(0.2, 0.12, 0.25),
    most=(0.5, 0.45, 0.85),
    styles={"day": Style(day)},
    spread=USUAL,
    round=False,
    alike=False,
    support="floor",
    also=("surface",),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.5, 5)},
    worktop=NO_APPLIANCE,
    lies=(
        Lies(
            on=("floor_by_wall", "floor_under_desk", "floor_by_door"),
            rooms=_DRY,
            clutter=2,
            weight=0.7,
            most=1,
        ),
    ),
    fixed=False,
    words="rucksack knapsack schoolbag school_bag",
    classes=Classes("bag", "bag", "bag", "backpack"),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "bag_cloth", "lock": "chrome"}, weight=2.0),
        Scheme({ANY: "hide", "lock": "brass"}),
    ),
    makes=(makes.row(ANY, makes.filled(90), "common"),),
    hinges=PLAIN_HINGES,
    yields=0.03,
)
