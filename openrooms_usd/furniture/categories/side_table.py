"""Small tables beside seats and beds."""

from typing import Final

from openrooms_usd.furniture.categories.table import tulip_side
from openrooms_usd.furniture.construction import TABLE_ROWS
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.joinery.small_table import block, bracket, compact, nightstand, tripod
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import TABLES

CATEGORY: Final = BuiltCategory(
    description="a small table beside a seat or a bed",
    size=(0.45, 0.45, 0.52),
    min_size=(0.22, 0.22, 0.3),
    max_size=(0.9, 0.9, 0.85),
    styles={
        "disc": Style(tulip_side, lambda size: max(size[:2]) < 1.03 * min(size[:2])),
        "tripod": Style(tripod, compact),
        "nightstand": Style(nightstand, lambda size: size[2] > 0.4, (0.46, 0.4, 0.55)),
        "bracket": Style(bracket, lambda size: size[2] > 0.45, (0.45, 0.34, 0.58)),
        "block": Style(block, compact, (0.36, 0.36, 0.45)),
    },
    round=True,
    mass_range=(1.5, 16),
    words="end_table endtable",
    classes=Classes("table", "table", "table"),
    schemes=TABLES,
    construction=TABLE_ROWS,
    offers_surfaces=("side_table", "low_shelf", "drawer"),
    view_importance=0.4,
)
