"""Laptops: slim, thick, and tablets with a keyboard."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import RIGID, Classes, Losses
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.computing import laptop_classic, laptop_slim, laptop_tablet
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.lying import Lies

CATEGORY: Final = BuiltCategory(
    description="an open laptop; its lid turns",
    size=(0.33, 0.3, 0.22),
    least=(0.2, 0.16, 0.12),
    most=(0.5, 0.5, 0.4),
    styles={
        "slim": Style(laptop_slim),
        "classic": Style(laptop_classic, size=(0.36, 0.34, 0.25)),
        "tablet": Style(laptop_tablet, size=(0.29, 0.3, 0.2)),
    },
    spread=USUAL,
    round=False,
    alike=True,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (1, 3.5)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="laptop_computer notebook",
    classes=Classes("laptop", "otherprop", "computer", "laptop"),
    synsets=("03642806",),
    schemes=(
        Scheme({ANY: "aluminium", "hinge": "black_plastic", "key": "black_plastic"}, weight=2.0),
        Scheme({ANY: "dark_plastic", "touchpad": "membrane", "key": "membrane"}),
    ),
    makes=(
        makes.row("screen", makes.solid(2500), "common"),
        makes.row("lid", makes.filled(600), "weight"),
        makes.row(ANY, makes.filled(1050), "weight"),
    ),
    hinges=Losses(0.05, 0.8),
    yields=RIGID,
    lies=(
        Lies(on=("coffee_table", "dining_table"), clutter=2, weight=0.3, most=1),
        Lies(on=("desk",), rooms=("office", "conference_room", "library"), weight=0.4),
    ),
)
