"""A plain box: what is kept of things that the library does not know."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import (
    BY_PARTS,
    NO_SYNSET,
    PLAIN_HINGES,
    RIGID,
    UNLABELED,
    Classes,
)
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    WIDE,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, board
from openrooms_usd.library.furniture.lying import Lies


def plain(size: Size, rng: np.random.Generator) -> Parts:
    """A box with slightly rounded edges."""
    width, depth, height = size
    edge = min(0.004, 0.2 * min(size))
    low, high = (-0.5 * width, -0.5 * depth, 0.0), (0.5 * width, 0.5 * depth, height)
    return {"body": board(low, high, edge)}


_STORES: Final = ("storage", "basement", "garage", "copy_room", "mail_room", "laundry_room")

CATEGORY: Final = BuiltCategory(
    description="a plain box",
    size=(0.4, 0.3, 0.3),
    least=(0.02, 0.02, 0.02),
    most=(20.0, 20.0, 20.0),
    styles={"plain": Style(plain)},
    spread=WIDE,
    round=False,
    alike=False,
    support="floor",
    also=("surface",),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (1, 10)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="cardboard_box boxes crate carton storage_box storage_container",
    classes=Classes(UNLABELED, "box", "box", UNLABELED),
    synsets=NO_SYNSET,
    schemes=BY_PARTS,
    # A carton with light things in it.
    makes=(makes.row(ANY, makes.filled(100), "weight"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(on=("low_shelf", "shelf"), rooms=_STORES, weight=1.5, most=12, makes=3),
        Lies(on=("wardrobe_shelf", "cupboard", "drawer"), weight=0.8, most=4),
        Lies(on=("low_shelf", "shelf", "cabinet_top", "desk"), weight=0.3, most=3),
        Lies(on=("floor_corner", "floor_by_wall"), clutter=3, weight=0.5),
    ),
)
