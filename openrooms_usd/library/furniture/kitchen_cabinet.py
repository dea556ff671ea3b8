"""Kitchen cabinets on the wall."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import KITCHEN
from openrooms_usd.library.furniture.built import NO_APPLIANCE, NO_LAMP, STANDARD, BuiltCategory
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.kitchen import wall_doors, wall_flaps, wall_glass, wall_open

CATEGORY: Final = BuiltCategory(
    description="a kitchen cabinet on the wall",
    size=(0.8, 0.37, 0.7),
    least=(0.25, 0.2, 0.25),
    most=(4.0, 0.8, 1.3),
    styles={
        "doors": Style(wall_doors, takes=("fronts",)),
        "glass": Style(wall_glass, lambda size: size[2] > 0.4, takes=("fronts",)),
        "flaps": Style(wall_flaps, lambda size: size[0] > 0.5, takes=("fronts",)),
        "open": Style(wall_open),
    },
    spread=STANDARD,
    round=False,
    alike=False,
    support="wall",
    also=(),
    level=1.45,
    lumen=NO_LAMP,
    weighs={ANY: (12, 35)},
    worktop=NO_APPLIANCE,
    fixed=True,
    words="kitchen_cabinets kitchen_cupboard overhead_cabinet upper_cabinet wall_cabinet",
    classes=Classes("cabinet", "cabinet", "cabinet", UNLABELED),
    synsets=NO_SYNSET,
    schemes=KITCHEN,
    makes=makes.STORAGE,
    hinges=PLAIN_HINGES,
    yields=RIGID,
    carries=("shelf", "cupboard"),
    photographed=0.4,
)
