"""Stoves: a hob of gas or glass over an oven."""

from functools import partial
from typing import Final

from openrooms_usd.furniture.construction import COOKER_REST_ROWS, COOKER_ROWS, MACHINE_ROWS
from openrooms_usd.furniture.joinery.cooker import cooker, guarded
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import COOKERS

CATEGORY: Final = BuiltCategory(
    description="a hob over an oven",
    size=(0.6, 0.64, 0.92),
    min_size=(0.4, 0.4, 0.6),
    max_size=(1.6, 0.9, 1.4),
    styles={
        "gas": Style(partial(cooker, gas=True), lambda size: size[2] < 1.05),
        "glass": Style(partial(cooker, gas=False), lambda size: size[2] < 1.05),
        "guarded": Style(guarded, lambda size: size[2] > 0.98, (0.76, 0.68, 1.12)),
        "wide": Style(
            partial(cooker, gas=True, ovens=2), lambda size: size[0] > 0.85, (1.1, 0.66, 0.94)
        ),
    },
    size_variation=STANDARD,
    fixed=True,
    mass_range=(40, 100),
    words="cooker range kitchen_range cooking_range gas_cooker gas_range",
    classes=Classes("stove", "otherstructure", "stove", "oven"),
    synsets=("04330267",),
    schemes=COOKERS,
    construction=(*COOKER_ROWS, *MACHINE_ROWS, *COOKER_REST_ROWS),
    joint_damping=JointDamping(1.0, 2.0),
    offers_surfaces=("hob",),
    view_importance=1.0,
)
