"""Towels: folded, rolled up, hung from a hook, and over a rail."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.linens import (
    folded_pile,
    hung_cloth,
    over_bar,
    rolled,
    with_loop,
)
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme


def folded(size: Size, rng: np.random.Generator) -> Parts:
    """A towel folded into a flat packet."""
    return {"towel": folded_pile(size, 4, rng)}


def rolled_up(size: Size, rng: np.random.Generator) -> Parts:
    """A towel rolled up."""
    return {"towel": rolled(size, rng)}


def hung(size: Size, rng: np.random.Generator) -> Parts:
    """A towel that hangs from its loop."""
    return {"towel": with_loop(lambda rest: hung_cloth(rest, rng), size)}


def draped(size: Size, rng: np.random.Generator) -> Parts:
    """A towel over a rail."""
    return {"towel": over_bar(size, rng)}


CATEGORY: Final = BuiltCategory(
    description="a towel",
    size=(0.36, 0.25, 0.045),
    min_size=(0.1, 0.03, 0.02),
    max_size=(1.0, 0.6, 1.4),
    styles={
        "folded": Style(folded, lambda size: size[2] < 0.6 * size[1]),
        "rolled": Style(
            rolled_up, lambda size: size[2] > 0.6 * size[1] and size[0] > size[2], (0.3, 0.12, 0.12)
        ),
        "hung": Style(hung, lambda size: size[2] > 2.0 * size[0], (0.24, 0.12, 0.75)),
        "draped": Style(draped, lambda size: size[1] < 0.5 * size[2], (0.45, 0.05, 0.45)),
    },
    support="surface",
    alternative_supports=("wall",),
    mass_range=(0.15, 1.6),
    words="towels hand_towel bath_towel",
    lies_under=True,
    classes=Classes(nyu40="towel", ade20k="towel"),
    schemes=(scheme("terry"),),
    construction=(row(ANY, filled(190), "common"),),
    placements=(
        on("towel_rail", styles="draped", pose="draped"),
        on(
            "hook",
            "bathroom kitchen laundry_room",
            styles="hung",
            pose="hung",
            weight=1.2,
            max_groups=5,
        ),
        on(
            "shelf low_shelf cupboard wardrobe_shelf",
            "bathroom bedroom laundry_room",
            styles="folded",
            pose="stacked",
            count=(2, 5),
        ),
        on(
            "shelf low_shelf in_basket",
            "bathroom",
            styles="rolled",
            pose="row",
            count=(2, 4),
            weight=0.7,
        ),
        on(
            "bath_rim cabinet_top basin_edge appliance_top",
            "bathroom",
            styles="folded",
            pose="stacked",
            count=(1, 3),
            weight=0.5,
        ),
        on("bed_foot chair_seat", "bedroom", styles="folded", clutter=3, weight=0.2, max_groups=1),
        on(
            "chair_back",
            "bathroom bedroom",
            styles="draped",
            pose="draped",
            clutter=3,
            weight=0.2,
            max_groups=1,
        ),
    ),
)
