"""Panes that stand on the rim of a bathtub."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.assembly import Assembly
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Furniture, Size, Style, board

_PROFILE_M: Final = 0.025


def hung(size: Size, rng: np.random.Generator) -> Furniture:
    """A pane that turns about a profile at the wall, on its left."""
    width, depth, height = size
    made, x, y = Assembly(), 0.5 * width, 0.5 * depth
    made.add("frame", board((-x, -y, 0.0), (_PROFILE_M - x, y, height), 0.002))
    pane = board((_PROFILE_M + 0.002 - x, -0.003, 0.006), (x, 0.003, height), 0.001)
    names = made.add("pane", pane)
    names += made.add("seal", board((_PROFILE_M + 0.004 - x, -0.002, 0.0), (x, 0.002, 0.0058),
                                    0.0005))  # fmt: skip
    made.hinge("leaf", names, (_PROFILE_M + 0.002 - x, 0.0, 0.0), "left", 90.0)
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a pane of glass on the rim of a bathtub",
    size=(0.8, 0.03, 1.4),
    least=(0.4, 0.015, 0.9),
    most=(1.6, 0.06, 2.0),
    styles={"hung": Style(hung)},
    spread=STANDARD,
    round=False,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (10, 35)},
    worktop=NO_APPLIANCE,
    fixed=True,
    words="bath_screen bathtub_screen shower_door shower_doors glass_partition",
    classes=Classes(UNLABELED, "otherstructure", "screen_door", UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "chrome", "seal": "plastic"}, weight=3.0),
        Scheme({ANY: "chrome", "pane": "tinted_glass", "seal": "plastic"}),
        Scheme({ANY: "black", "seal": "plastic"}),
    ),
    makes=(
        makes.row("pane", makes.solid(2500), "common"),
        makes.row(ANY, makes.walls(1.5), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
