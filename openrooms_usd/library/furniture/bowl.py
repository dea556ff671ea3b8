"""Bowls."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import PLAIN_HINGES, RIGID, UNLABELED, Classes
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
from openrooms_usd.library.furniture.vessel import bowl_footed, bowl_fruit, bowl_oval, bowl_round

_KITCHENS: Final = ("kitchen", "apartment")

CATEGORY: Final = BuiltCategory(
    description="a bowl",
    size=(0.24, 0.24, 0.09),
    least=(0.08, 0.08, 0.03),
    most=(0.6, 0.6, 0.35),
    styles={
        "round": Style(bowl_round),
        "footed": Style(bowl_footed, size=(0.26, 0.26, 0.14)),
        "fruit": Style(bowl_fruit, size=(0.3, 0.3, 0.17)),
        "dish": Style(bowl_oval, size=(0.3, 0.2, 0.07)),
    },
    spread=USUAL,
    round=True,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.3, 3)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="bowls",
    classes=Classes("bowl", "otherprop", UNLABELED, "bowl"),
    synsets=("02880940",),
    schemes=(
        Scheme({ANY: "glaze"}, weight=3.0),
        Scheme({ANY: "wood"}),
    ),
    makes=(makes.row("container", makes.walls(3), "common", "specular_stone"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    carries=("in_bowl",),
    lies=(
        Lies(on=("worktop", "dining_table", "coffee_table"), weight=0.8, most=1),
        Lies(on=("shelf", "cabinet_top", "media_top", "dresser_top", "side_table"), weight=0.5),
        Lies(
            on=("cupboard", "shelf"),
            rooms=_KITCHENS,
            styles=("round",),
            pose="stacked",
            count=(2, 4),
            makes=1,
        ),
    ),
)
