"""Kitchen cabinets on the wall."""

from functools import partial
from typing import Final

from openrooms_usd.furniture.construction import STORAGE_ROWS
from openrooms_usd.furniture.joinery.kitchen import wall_doors, wall_flaps, wall_open
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import KITCHEN

CATEGORY: Final = BuiltCategory(
    description="a kitchen cabinet on the wall",
    size=(0.8, 0.37, 0.7),
    min_size=(0.25, 0.2, 0.25),
    max_size=(4.0, 0.8, 1.3),
    styles={
        "doors": Style(wall_doors, takes=("fronts",)),
        "glass": Style(
            partial(wall_doors, glass=True), lambda size: size[2] > 0.4, takes=("fronts",)
        ),
        "flaps": Style(wall_flaps, lambda size: size[0] > 0.5, takes=("fronts",)),
        "open": Style(wall_open),
    },
    size_variation=STANDARD,
    support="wall",
    mount_height=1.45,
    fixed=True,
    mass_range=(12, 35),
    words="kitchen_cabinets kitchen_cupboard overhead_cabinet upper_cabinet wall_cabinet",
    classes=Classes("cabinet", "cabinet", "cabinet"),
    schemes=KITCHEN,
    construction=STORAGE_ROWS,
    offers_surfaces=("shelf", "cupboard"),
    view_importance=0.4,
)
