"""Coasters below glasses and mugs."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.lofts import rounded_rectangle, superellipse
from openrooms_usd.geometry.sweeps import extrude
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style
from openrooms_usd.library.furniture.lying import Lies


def disc(size: Size, rng: np.random.Generator) -> Parts:
    """A round coaster with a rounded edge."""
    width, depth, height = size
    return {"coaster": extrude(superellipse(width, depth, 2.0, 28), height, bevel=0.3 * height)}


def tile(size: Size, rng: np.random.Generator) -> Parts:
    """A square coaster."""
    width, depth, height = size
    return {"coaster": extrude(rounded_rectangle(width, depth, 0.008, 4), height, bevel=0.0012)}


CATEGORY: Final = BuiltCategory(
    description="a coaster below a glass",
    size=(0.1, 0.1, 0.006),
    least=(0.06, 0.06, 0.005),
    most=(0.2, 0.2, 0.02),
    styles={"disc": Style(disc), "tile": Style(tile)},
    spread=STANDARD,
    round=True,
    alike=True,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.01, 0.25)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="coasters",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "cork"}), Scheme({ANY: "wood"}), Scheme({ANY: "stone"}, weight=0.7)),
    makes=(
        makes.row(ANY, makes.solid(2500), "common", "specular_stone"),
        makes.row(ANY, makes.solid(500), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(
            on=("coffee_table", "desk", "side_table"),
            pose="stacked",
            count=(1, 4),
            weight=0.3,
            most=2,
        ),
    ),
)
