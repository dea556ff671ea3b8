"""Remote controls: a long one full of keys, and a short one with a ring."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.handheld import keyed
from openrooms_usd.library.furniture.joinery import Parts, Size, Style
from openrooms_usd.library.furniture.lying import Lies


def full(size: Size, rng: np.random.Generator) -> Parts:
    """A long one with many keys."""
    return keyed(size, 11, ring=False, rng=rng)


def slim(size: Size, rng: np.random.Generator) -> Parts:
    """A short one with a ring of directions."""
    return keyed(size, 5, ring=True, rng=rng)


CATEGORY: Final = BuiltCategory(
    description="a remote control",
    size=(0.047, 0.2, 0.022),
    least=(0.02, 0.08, 0.008),
    most=(0.1, 0.35, 0.05),
    styles={"full": Style(full), "slim": Style(slim, size=(0.038, 0.145, 0.016))},
    spread=STANDARD,
    round=False,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.04, 0.25)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="remote tv_remote remotes controller",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, "remote"),
    synsets=("04074963",),
    schemes=(
        Scheme(
            {ANY: "black_plastic", "button": "dark_plastic", "switch": "toy_plastic"}, weight=3.0
        ),
        Scheme({ANY: "plastic", "button": "grey", "switch": "toy_plastic"}),
    ),
    makes=(makes.row(ANY, makes.filled(750), "weight"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(
            on=("coffee_table", "media_top"),
            rooms=("living_room", "bedroom"),
            pose="flat",
            weight=1.0,
            count=(1, 2),
            cluster="media",
            most=2,
        ),
        Lies(
            on=("sofa_arm", "sofa_seat", "armchair_seat", "side_table"),
            pose="flat",
            clutter=2,
            weight=0.5,
            most=1,
        ),
        Lies(on=("bedside",), pose="flat", weight=0.2, most=1),
    ),
)
