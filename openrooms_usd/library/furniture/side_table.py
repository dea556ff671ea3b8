"""Small tables beside seats and beds."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import TABLES
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.small_table import block, bracket, compact, nightstand, tripod
from openrooms_usd.library.furniture.table import tulip_side

CATEGORY: Final = BuiltCategory(
    description="a small table beside a seat or a bed",
    size=(0.45, 0.45, 0.52),
    least=(0.22, 0.22, 0.3),
    most=(0.9, 0.9, 0.85),
    styles={
        "disc": Style(tulip_side, lambda size: max(size[:2]) < 1.03 * min(size[:2])),
        "tripod": Style(tripod, compact),
        "nightstand": Style(nightstand, lambda size: size[2] > 0.4, (0.46, 0.4, 0.55)),
        "bracket": Style(bracket, lambda size: size[2] > 0.45, (0.45, 0.34, 0.58)),
        "block": Style(block, compact, (0.36, 0.36, 0.45)),
    },
    spread=USUAL,
    round=True,
    alike=False,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (1.5, 16)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="end_table endtable",
    classes=Classes("table", "table", "table", UNLABELED),
    synsets=NO_SYNSET,
    schemes=TABLES,
    makes=makes.TABLE,
    hinges=PLAIN_HINGES,
    yields=RIGID,
    carries=("side_table", "low_shelf", "drawer"),
    photographed=0.4,
)
