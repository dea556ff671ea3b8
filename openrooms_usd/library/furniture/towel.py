"""Towels: folded, rolled up, hung from a hook, and over a rail."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style
from openrooms_usd.library.furniture.linens import (
    folded_pile,
    hung_cloth,
    over_bar,
    rolled,
    with_loop,
)
from openrooms_usd.library.furniture.lying import Lies


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
    least=(0.1, 0.03, 0.02),
    most=(1.0, 0.6, 1.4),
    styles={
        "folded": Style(folded, lambda size: size[2] < 0.6 * size[1]),
        "rolled": Style(
            rolled_up, lambda size: size[2] > 0.6 * size[1] and size[0] > size[2], (0.3, 0.12, 0.12)
        ),
        "hung": Style(hung, lambda size: size[2] > 2.0 * size[0], (0.24, 0.12, 0.75)),
        "draped": Style(draped, lambda size: size[1] < 0.5 * size[2], (0.45, 0.05, 0.45)),
    },
    spread=USUAL,
    round=False,
    alike=False,
    support="surface",
    also=("wall",),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.15, 1.6)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="towels hand_towel bath_towel",
    classes=Classes(UNLABELED, "towel", "towel", UNLABELED),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "terry"}),),
    makes=(makes.row(ANY, makes.filled(190), "common"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(on=("towel_rail",), styles=("draped",), pose="draped", weight=1.0),
        Lies(
            on=("hook",),
            rooms=("bathroom", "kitchen", "laundry_room"),
            styles=("hung",),
            pose="hung",
            weight=1.2,
            most=5,
        ),
        Lies(
            on=("shelf", "low_shelf", "cupboard", "wardrobe_shelf"),
            rooms=("bathroom", "bedroom", "laundry_room"),
            styles=("folded",),
            pose="stacked",
            count=(2, 5),
        ),
        Lies(
            on=("shelf", "low_shelf", "in_basket"),
            rooms=("bathroom",),
            styles=("rolled",),
            pose="row",
            count=(2, 4),
            weight=0.7,
        ),
        Lies(
            on=("bath_rim", "cabinet_top", "basin_edge", "appliance_top"),
            rooms=("bathroom",),
            styles=("folded",),
            pose="stacked",
            count=(1, 3),
            weight=0.5,
        ),
        Lies(
            on=("bed_foot", "chair_seat"),
            rooms=("bedroom",),
            styles=("folded",),
            clutter=3,
            weight=0.2,
            most=1,
        ),
        Lies(
            on=("chair_back",),
            rooms=("bathroom", "bedroom"),
            styles=("draped",),
            pose="draped",
            clutter=3,
            weight=0.2,
            most=1,
        ),
    ),
)
