"""Kitchen units with a worktop."""

from typing import Final

from openrooms_usd.furniture.construction import STORAGE_ROWS
from openrooms_usd.furniture.joinery.kitchen import (
    counter_doors,
    counter_drawers,
    counter_open,
    island,
)
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

CATEGORY: Final = BuiltCategory(
    description="a kitchen unit with a worktop",
    size=(1.2, 0.62, 0.91),
    min_size=(0.25, 0.35, 0.6),
    max_size=(6.0, 1.5, 1.2),
    styles={
        "doors": Style(counter_doors),
        "drawers": Style(counter_drawers),
        "open": Style(counter_open, lambda size: size[0] > 0.8),
        "island": Style(island, lambda size: size[1] > 0.78, (1.8, 0.95, 0.91)),
    },
    size_variation=STANDARD,
    fixed=True,
    words="kitchen_counter countertop kitchen_island bar_counter bar counter_top island",
    classes=Classes("counter", "counter", "counter"),
    schemes=(
        scheme("white", wood="countertop", black="base", weight=2.0),
        scheme("white", stone="countertop", weight=2.0),
        scheme("wood", stone="countertop"),
        scheme("lacquer", white="frame shelf drawer_box", stone="countertop", black="base"),
    ),
    construction=STORAGE_ROWS,
    offers_surfaces=("worktop", "shelf", "low_shelf", "cupboard", "drawer"),
    view_importance=1.0,
)
