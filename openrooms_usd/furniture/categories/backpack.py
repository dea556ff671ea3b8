"""Backpacks that stand on their base: a soft body, a front pocket, straps and a loop."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import seated, tapered
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cushion
from openrooms_usd.geometry.sweeps import tube

_DRY: Final = (
    "living_room bedroom office hallway apartment classroom library hotel computer_cluster "
    "game_room gym lounge conference_room closet"
)


def _straps(width: float, height: float, back: float, strap: float) -> list[Mesh]:
    """The two straps over the shoulders."""
    return [
        tube(
            [
                (s * 0.3 * width, back - strap, 0.08 * height),
                (s * 0.34 * width, back - 0.006, 0.4 * height),
                (s * 0.16 * width, back - 0.006, 0.8 * height),
                (s * 0.12 * width, back - strap - 0.04, 0.9 * height),
            ],
            0.006,
            bend=0.04,
            segments=8,
        )
        for s in (-1.0, 1.0)
    ]


def day(size: Size, rng: np.random.Generator) -> Parts:
    """A school or city backpack, narrower above."""
    width, depth, height = size
    back, strap, sag = 0.5 * depth, 0.02, 0.014
    deep = 0.72 * depth
    high = height - 0.03
    whole = cushion(
        (1.056 * width, deep, high + sag),
        crown=(0.012, 0.02, 0.01),
        center=(0.0, back - strap - 0.5 * deep, 0.5 * (high - sag)),
    )
    body = seated(tapered(whole, "z", (0.86, 0.72)))
    pocket = cushion(
        (0.74 * width, 0.4 * depth, 0.42 * height),
        radius=0.03,
        crown=(0.006, 0.012, 0.008),
        center=(0.0, -back + 0.2 * depth, 0.06 + 0.21 * height),
    )
    straps = _straps(width, height, back, strap)
    y = back - strap - 0.3 * deep
    loop = tube(
        [
            (-0.04, y, high - 0.02),
            (-0.03, y, height - 0.006),
            (0.03, y, height - 0.006),
            (0.04, y, high - 0.02),
        ],
        0.006,
        bend=0.012,
        segments=8,
    )
    zips = [
        board(
            (-0.3 * width, -back + 0.001, 0.07 + 0.34 * height),
            (0.3 * width, -back + 0.03, 0.076 + 0.34 * height),
            0.001,
        )
    ]
    return {
        "bag": body,
        "pocket": pocket,
        **numbered("strap", [*straps, loop]),
        **numbered("lock", zips),
    }


CATEGORY: Final = BuiltCategory(
    description="a backpack",
    size=(0.32, 0.24, 0.46),
    min_size=(0.2, 0.12, 0.25),
    max_size=(0.5, 0.45, 0.85),
    styles={"day": Style(day)},
    alternative_supports=("surface",),
    mass_range=(0.5, 5),
    words="rucksack knapsack schoolbag school_bag",
    classes=Classes("bag", "bag", "bag", "backpack"),
    schemes=(scheme("bag_cloth", chrome="lock", weight=2.0), scheme("hide", brass="lock")),
    construction=(row(ANY, filled(90), "common"),),
    collision_softness=0.03,
    placements=(
        on(
            "floor_by_wall floor_under_desk floor_by_door",
            _DRY,
            clutter=2,
            weight=0.7,
            max_groups=1,
        ),
    ),
)
