"""Ovens to be built in."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, RIGID, UNLABELED, Classes, Losses
from openrooms_usd.categories.schemes import COOKERS
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.cooker import double, single, swinging
from openrooms_usd.library.furniture.joinery import Style

CATEGORY: Final = BuiltCategory(
    description="an oven to be built in",
    size=(0.6, 0.6, 0.6),
    least=(0.35, 0.35, 0.35),
    most=(1.2, 0.9, 1.6),
    styles={
        "single": Style(single, lambda size: size[2] < 0.95),
        "double": Style(double, lambda size: size[2] >= 0.8, (0.6, 0.6, 1.1)),
        "swinging": Style(swinging, lambda size: size[2] < 0.95),
    },
    spread=STANDARD,
    round=False,
    alike=False,
    support="floor",
    also=("wall",),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (22, 45), "double": (40, 75)},
    worktop=NO_APPLIANCE,
    fixed=True,
    words="built_in_oven",
    classes=Classes(UNLABELED, "otherstructure", "oven", "oven"),
    synsets=NO_SYNSET,
    schemes=COOKERS,
    makes=(
        *makes.COOKER,
        *makes.MACHINE,
        *makes.COOKER_REST,
    ),
    hinges=Losses(1.0, 2.0),
    yields=RIGID,
    photographed=0.8,
)
