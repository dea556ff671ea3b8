"""Dishwashers: one door that drops, or two drawers."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import RIGID, UNLABELED, Classes, Losses
from openrooms_usd.categories.schemes import PANELLED, Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.laundry import console, integrated, two_drawers

CATEGORY: Final = BuiltCategory(
    description="a dishwasher",
    size=(0.6, 0.62, 0.86),
    least=(0.4, 0.4, 0.45),
    most=(0.9, 0.8, 1.1),
    styles={
        "console": Style(console),
        "integrated": Style(integrated, takes=("fronts",)),
        "drawers": Style(two_drawers),
    },
    spread=STANDARD,
    round=False,
    alike=False,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (30, 55)},
    worktop=NO_APPLIANCE,
    fixed=True,
    words="dish_washer",
    classes=Classes("dishwasher", "otherstructure", "dishwasher", UNLABELED),
    synsets=("03207941",),
    schemes=(
        Scheme({ANY: "enamel", "container": "steel", "handle": "steel"}),
        Scheme({ANY: "steel", "frame": "grey", "base": "black"}, weight=2.0),
        *PANELLED,
    ),
    makes=(
        makes.row("base", makes.filled(400), "weight"),
        *makes.MACHINE,
        makes.row(ANY, makes.filled(130), "weight"),
    ),
    hinges=Losses(1.0, 2.0),
    yields=RIGID,
    photographed=0.5,
)
