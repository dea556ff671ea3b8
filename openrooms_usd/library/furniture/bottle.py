"""Bottles: of glass, of sheet metal, with a pump."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import PLAIN_HINGES, RIGID, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.lying import Lies
from openrooms_usd.library.furniture.vessel import bottle_pump, bottle_sport, bottle_wine

_STORES: Final = ("storage", "basement", "garage", "copy_room", "mail_room", "laundry_room")

CATEGORY: Final = BuiltCategory(
    description="a bottle",
    size=(0.08, 0.08, 0.3),
    least=(0.03, 0.03, 0.08),
    most=(0.2, 0.2, 0.6),
    styles={
        "wine": Style(bottle_wine),
        "sport": Style(bottle_sport, size=(0.073, 0.073, 0.26)),
        "pump": Style(bottle_pump, size=(0.075, 0.075, 0.19)),
    },
    spread=USUAL,
    round=True,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.15, 0.9)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="water_bottle bottles",
    classes=Classes("bottle", "otherprop", "bottle", "bottle"),
    synsets=("02876657",),
    schemes=(
        Scheme({ANY: "aluminium", "lid": "black_plastic", "handle": "black_plastic"}),
        Scheme(
            {ANY: "glaze", "lid": "steel", "frame": "steel", "handle": "steel"},
            needs="frame",
            weight=100.0,
        ),
        Scheme(
            {ANY: "bottle_glass", "lid": "bottle_label", "label": "bottle_label"},
            needs="label",
            weight=100.0,
        ),
    ),
    makes=(
        makes.row("container", makes.walls(3), "common", "specular_stone"),
        makes.row("container", makes.walls(0.6), "sheet", "metal"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(on=("basin_edge", "sink_edge", "bath_rim"), styles=("pump",), cluster="washing"),
        Lies(on=("worktop", "dining_table", "cabinet_top"), styles=("wine",), weight=0.6),
        Lies(
            on=("desk", "bedside", "coffee_table", "shop_counter", "appliance_top"),
            styles=("sport",),
            weight=0.6,
            clutter=2,
        ),
        Lies(on=("shelf", "cupboard"), rooms=_STORES, pose="row", count=(2, 4), weight=0.7),
    ),
)
