"""Low tables before seats."""

from typing import Final

from openrooms_usd.furniture.categories.table import shelf
from openrooms_usd.furniture.construction import TABLE_ROWS
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.joinery.small_table import chest, compact, drum, hairpin, sled
from openrooms_usd.furniture.record import MADE_TO_MEASURE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import TABLES

CATEGORY: Final = BuiltCategory(
    description="a low table before seats",
    size=(1.1, 0.6, 0.42),
    min_size=(0.4, 0.4, 0.25),
    max_size=(2.0, 1.6, 0.6),
    styles={
        "shelf": Style(shelf),
        "hairpin": Style(hairpin),
        "drum": Style(drum, compact, (0.8, 0.8, 0.4)),
        "sled": Style(sled),
        "chest": Style(chest, lambda size: size[0] > 0.7 and size[2] > 0.3),
    },
    size_variation=MADE_TO_MEASURE,
    mass_range=(9, 50),
    words="cocktail_table tea_table",
    classes=Classes("table", "table", "coffee_table"),
    schemes=TABLES,
    construction=TABLE_ROWS,
    offers_surfaces=("coffee_table", "low_shelf"),
    view_importance=1.5,
)
