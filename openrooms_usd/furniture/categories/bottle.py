"""Bottles: of glass, of sheet metal, with a pump."""

from typing import Final

from openrooms_usd.furniture.construction import row, walls
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.joinery.vessel import bottle_pump, bottle_sport, bottle_wine
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

_STORES: Final = "storage basement garage copy_room mail_room laundry_room"

# Where people drink wine.
_MEALS: Final = "apartment dining_room game_room hotel kitchen living_room lobby lounge"
CATEGORY: Final = BuiltCategory(
    description="a bottle",
    size=(0.08, 0.08, 0.3),
    min_size=(0.03, 0.03, 0.08),
    max_size=(0.2, 0.2, 0.6),
    styles={
        "wine": Style(bottle_wine, rooms=_MEALS),
        "sport": Style(bottle_sport, size=(0.073, 0.073, 0.26)),
        "pump": Style(bottle_pump, size=(0.075, 0.075, 0.19)),
    },
    round=True,
    support="surface",
    mass_range=(0.15, 0.9),
    words="water_bottle bottles",
    classes=Classes("bottle", "otherprop", "bottle", "bottle"),
    synsets=("02876657",),
    schemes=(
        scheme("aluminium", black_plastic="lid handle"),
        scheme("glaze", steel="lid frame handle", needs="frame", weight=100.0),
        scheme("bottle_glass", bottle_label="lid label", needs="label", weight=100.0),
    ),
    construction=(
        row("container", walls(3), "common", "specular_stone"),
        row("container", walls(0.6), "sheet", "metal"),
    ),
    placements=(
        on("basin_edge sink_edge bath_rim", styles="pump", cluster="washing"),
        on("worktop dining_table cabinet_top", _MEALS, styles="wine", weight=0.6),
        on("desk bedside coffee_table shop_counter", styles="sport", weight=0.6, clutter=2),
        on("shelf cupboard", _STORES, pose="row", count=(2, 4), weight=0.7, max_variants=4),
    ),
)
