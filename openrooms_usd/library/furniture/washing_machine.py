"""Washing machines: portholes, lids, and one under a dryer."""

from typing import Final

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
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.laundry import front_loader, stacked, top_loader

CATEGORY: Final = BuiltCategory(
    description="a washing machine",
    size=(0.6, 0.6, 0.86),
    least=(0.4, 0.4, 0.55),
    most=(0.9, 0.9, 2.1),
    styles={
        "front_loader": Style(front_loader, lambda size: size[2] < 1.3),
        "top_loader": Style(top_loader, lambda size: size[2] < 1.3, (0.66, 0.66, 1.05)),
        "stacked": Style(stacked, lambda size: size[2] >= 1.3, (0.6, 0.62, 1.72)),
    },
    spread=STANDARD,
    round=False,
    alike=True,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (55, 90), "stacked": (80, 140)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="washer washer_dryer washing_machines clothes_dryer dryer laundry_machine",
    classes=Classes("washing_machine", "otherfurniture", "washer", UNLABELED),
    synsets=("04554684",),
    schemes=(
        Scheme({ANY: "enamel", "handle": "chrome", "base": "black"}, weight=2.0),
        Scheme(
            {ANY: "enamel", "handle": "chrome", "base": "black", "door": "chrome", "panel": "grey"}
        ),
        Scheme({ANY: "grey", "handle": "chrome", "base": "black", "knob": "chrome"}),
    ),
    makes=(
        makes.row("drum", makes.filled(8000), "weight"),
        makes.row("top", makes.filled(2000), "weight"),
        *makes.MACHINE,
        makes.row(ANY, makes.filled(215), "weight"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    carries=("appliance_top",),
    photographed=1.5,
)
