"""Ovens to be built in."""

from functools import partial
from typing import Final

from openrooms_usd.furniture.construction import COOKER_REST_ROWS, COOKER_ROWS, MACHINE_ROWS
from openrooms_usd.furniture.joinery.cooker import oven
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import COOKERS

CATEGORY: Final = BuiltCategory(
    description="an oven to be built in",
    size=(0.6, 0.6, 0.6),
    min_size=(0.35, 0.35, 0.35),
    max_size=(1.2, 0.9, 1.6),
    styles={
        "single": Style(oven, lambda size: size[2] < 0.95),
        "double": Style(
            partial(oven, cells=2),
            lambda size: size[2] >= 0.8,
            (0.6, 0.6, 1.1),
            mass_range=(40, 75),
        ),
        "swinging": Style(partial(oven, side=True), lambda size: size[2] < 0.95),
    },
    size_variation=STANDARD,
    alternative_supports=("wall",),
    fixed=True,
    mass_range=(22, 45),
    words="built_in_oven",
    classes=Classes(nyu40="otherstructure", ade20k="oven", coco="oven"),
    schemes=COOKERS,
    construction=(*COOKER_ROWS, *MACHINE_ROWS, *COOKER_REST_ROWS),
    joint_damping=JointDamping(1.0, 2.0),
    view_importance=0.8,
)
