"""Kitchen units with a worktop."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NEVER_WEIGHED,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.kitchen import (
    counter_doors,
    counter_drawers,
    counter_open,
    island,
)

CATEGORY: Final = BuiltCategory(
    description="a kitchen unit with a worktop",
    size=(1.2, 0.62, 0.91),
    least=(0.25, 0.35, 0.6),
    most=(6.0, 1.5, 1.2),
    styles={
        "doors": Style(counter_doors),
        "drawers": Style(counter_drawers),
        "open": Style(counter_open, lambda size: size[0] > 0.8),
        "island": Style(island, lambda size: size[1] > 0.78, (1.8, 0.95, 0.91)),
    },
    spread=STANDARD,
    round=False,
    alike=False,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs=NEVER_WEIGHED,
    worktop=NO_APPLIANCE,
    fixed=True,
    words="kitchen_counter countertop kitchen_island bar_counter bar counter_top island",
    classes=Classes("counter", "counter", "counter", UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "white", "countertop": "wood", "base": "black"}, weight=2.0),
        Scheme({ANY: "white", "countertop": "stone"}, weight=2.0),
        Scheme({ANY: "wood", "countertop": "stone"}),
        Scheme(
            {
                ANY: "lacquer",
                "frame": "white",
                "shelf": "white",
                "drawer_box": "white",
                "countertop": "stone",
                "base": "black",
            }
        ),
    ),
    makes=makes.STORAGE,
    hinges=PLAIN_HINGES,
    yields=RIGID,
    carries=("worktop", "shelf", "low_shelf", "cupboard", "drawer"),
    photographed=1.0,
)
