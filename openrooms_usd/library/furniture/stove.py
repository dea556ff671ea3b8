"""Stoves: a hob of gas or glass over an oven."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import RIGID, Classes, Losses
from openrooms_usd.categories.schemes import COOKERS
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.cooker import gas, glass, guarded, wide
from openrooms_usd.library.furniture.joinery import Style

CATEGORY: Final = BuiltCategory(
    description="a hob over an oven",
    size=(0.6, 0.64, 0.92),
    least=(0.4, 0.4, 0.6),
    most=(1.6, 0.9, 1.4),
    styles={
        "gas": Style(gas, lambda size: size[2] < 1.05),
        "glass": Style(glass, lambda size: size[2] < 1.05),
        "guarded": Style(guarded, lambda size: size[2] > 0.98, (0.76, 0.68, 1.12)),
        "wide": Style(wide, lambda size: size[0] > 0.85, (1.1, 0.66, 0.94)),
    },
    spread=STANDARD,
    round=False,
    alike=False,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (40, 100)},
    worktop=NO_APPLIANCE,
    fixed=True,
    words="cooker range kitchen_range cooking_range gas_cooker gas_range",
    classes=Classes("stove", "otherstructure", "stove", "oven"),
    synsets=("04330267",),
    schemes=COOKERS,
    makes=(
        *makes.COOKER,
        *makes.MACHINE,
        *makes.COOKER_REST,
    ),
    hinges=Losses(1.0, 2.0),
    yields=RIGID,
    carries=("hob",),
    photographed=1.0,
)
