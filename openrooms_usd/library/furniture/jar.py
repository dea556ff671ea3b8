"""Jars with lids."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import METAL, Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    WIDE,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.lying import Lies
from openrooms_usd.library.furniture.vessel import jar_canister, jar_ginger, jar_preserving

_KITCHENS: Final = ("kitchen", "apartment")

CATEGORY: Final = BuiltCategory(
    description="a jar with a lid",
    size=(0.11, 0.11, 0.17),
    least=(0.04, 0.04, 0.05),
    most=(0.5, 0.5, 0.7),
    styles={
        "ginger": Style(jar_ginger, size=(0.17, 0.17, 0.24)),
        "preserving": Style(jar_preserving, size=(0.09, 0.09, 0.15)),
        "canister": Style(jar_canister),
    },
    spread=WIDE,
    round=True,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.2, 2)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="canister",
    classes=Classes("jar", "otherprop", UNLABELED, UNLABELED),
    synsets=("03593526",),
    schemes=(
        Scheme({ANY: "glaze", "handle": "glaze"}),
        Scheme(
            {ANY: "glaze", "lid": "wood", "seal": "membrane", "label": "bottle_label"},
            needs="seal",
            weight=100.0,
        ),
        Scheme({ANY: "bottle_glass", "lid": METAL, "frame": METAL}, needs="frame", weight=100.0),
    ),
    makes=(
        makes.row("container", makes.walls(3), "common", "specular_stone"),
        makes.row("lid", makes.walls(0.4), "sheet", "metal"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(
            on=("worktop", "shelf", "cupboard"),
            rooms=_KITCHENS,
            count=(2, 4),
            cluster="cooking",
            makes=4,
        ),
        Lies(on=("worktop", "dining_table", "mantel"), weight=0.6, cluster="cooking"),
        Lies(on=("shelf", "cabinet_top", "dresser_top", "media_top", "desk"), weight=0.5),
    ),
)
