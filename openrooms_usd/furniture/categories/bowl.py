"""Bowls."""

from typing import Final

from openrooms_usd.furniture.construction import row, walls
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.joinery.vessel import bowl_footed, bowl_fruit, bowl_oval, bowl_round
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

_KITCHENS: Final = "kitchen apartment"

CATEGORY: Final = BuiltCategory(
    description="a bowl",
    size=(0.24, 0.24, 0.09),
    min_size=(0.08, 0.08, 0.03),
    max_size=(0.6, 0.6, 0.35),
    styles={
        "round": Style(bowl_round),
        "footed": Style(bowl_footed, size=(0.26, 0.26, 0.14)),
        "fruit": Style(bowl_fruit, size=(0.3, 0.3, 0.17)),
        "dish": Style(bowl_oval, size=(0.3, 0.2, 0.07)),
    },
    round=True,
    support="surface",
    mass_range=(0.3, 3),
    words="bowls",
    classes=Classes(openrooms45="bowl", coco="bowl"),
    synsets=("02880940",),
    schemes=(scheme("glaze", weight=3.0), scheme("wood")),
    construction=(row("container", walls(3), "common", "specular_stone"),),
    placements=(
        on("worktop dining_table coffee_table", weight=0.8, max_groups=1),
        on("shelf cabinet_top media_top dresser_top side_table", weight=0.5),
        on(
            "cupboard shelf",
            _KITCHENS,
            styles="round",
            pose="stacked",
            count=(2, 4),
            max_variants=1,
        ),
    ),
    offers_surfaces=("in_bowl",),
)
