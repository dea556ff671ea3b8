"""Televisions: on feet, on a pedestal, for a wall, and with a tube."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, Classes
from openrooms_usd.categories.schemes import SCREENS, Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.screen import (
    deep,
    television_feet,
    television_mounted,
    television_pedestal,
    television_tube,
)

CATEGORY: Final = BuiltCategory(
    description="a television, on a stand or for a wall",
    size=(1.1, 0.24, 0.7),
    least=(0.3, 0.06, 0.22),
    most=(2.4, 0.8, 1.5),
    styles={
        "feet": Style(television_feet, lambda size: size[1] > 0.14 and not deep(size)),
        "pedestal": Style(television_pedestal, lambda size: size[1] > 0.14 and not deep(size)),
        "mounted": Style(television_mounted, lambda size: size[1] <= 0.14, (1.1, 0.07, 0.63)),
        "tube": Style(television_tube, deep, (0.6, 0.48, 0.64)),
    },
    spread=USUAL,
    round=False,
    alike=False,
    support="surface",
    also=("wall",),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (8, 25), "tube": (25, 60)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="tv television_set flat_screen tv_monitor tv_screen",
    classes=Classes("monitor", "television", "television_receiver", "tv"),
    synsets=NO_SYNSET,
    schemes=(
        *SCREENS,
        Scheme(
            {ANY: "black_plastic", "frame": "wood", "antenna": "steel"},
            needs="antenna",
            weight=200.0,
        ),
    ),
    makes=(
        makes.row(ANY, makes.filled(350), "weight"),
        makes.row("screen", makes.solid(2500), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    photographed=1.0,
)
