"""Televisions: on feet, on a pedestal, for a wall, and with a tube."""

from typing import Final

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.joinery.screen import (
    deep,
    television_feet,
    television_mounted,
    television_pedestal,
    television_tube,
)
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import SCREENS, scheme

CATEGORY: Final = BuiltCategory(
    description="a television, on a stand or for a wall",
    size=(1.1, 0.24, 0.7),
    min_size=(0.3, 0.06, 0.22),
    max_size=(2.4, 0.8, 1.5),
    styles={
        "feet": Style(television_feet, lambda size: size[1] > 0.14 and not deep(size)),
        "pedestal": Style(television_pedestal, lambda size: size[1] > 0.14 and not deep(size)),
        "mounted": Style(television_mounted, lambda size: size[1] <= 0.14, (1.1, 0.07, 0.63)),
        "tube": Style(television_tube, deep, (0.6, 0.48, 0.64), mass_range=(25, 60), weight=0.03),
    },
    support="surface",
    alternative_supports=("wall",),
    mass_range=(8, 25),
    words="tv television_set flat_screen tv_monitor tv_screen",
    classes=Classes("monitor", "television", "television_receiver", "tv"),
    schemes=(
        *SCREENS,
        scheme("black_plastic", wood="frame", steel="antenna", needs="antenna", weight=200.0),
    ),
    construction=(row(ANY, filled(350), "weight"), row("screen", solid(2500), "common")),
    view_importance=1.0,
)
