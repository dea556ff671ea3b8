"""Low tables before seats."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import TABLES
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    MADE_TO_MEASURE,
    NO_APPLIANCE,
    NO_LAMP,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.small_table import chest, compact, drum, hairpin, sled
from openrooms_usd.library.furniture.table import shelf

CATEGORY: Final = BuiltCategory(
    description="a low table before seats",
    size=(1.1, 0.6, 0.42),
    least=(0.4, 0.4, 0.25),
    most=(2.0, 1.6, 0.6),
    styles={
        "shelf": Style(shelf),
        "hairpin": Style(hairpin),
        "drum": Style(drum, compact, (0.8, 0.8, 0.4)),
        "sled": Style(sled),
        "chest": Style(chest, lambda size: size[0] > 0.7 and size[2] > 0.3),
    },
    spread=MADE_TO_MEASURE,
    round=False,
    alike=False,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (9, 50)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="cocktail_table tea_table",
    classes=Classes("table", "table", "coffee_table", UNLABELED),
    synsets=NO_SYNSET,
    schemes=TABLES,
    makes=makes.TABLE,
    hinges=PLAIN_HINGES,
    yields=RIGID,
    carries=("coffee_table", "low_shelf"),
    photographed=1.5,
)
