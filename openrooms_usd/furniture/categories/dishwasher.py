"""Dishwashers: one door that drops, or two drawers."""

from typing import Final

from openrooms_usd.furniture.construction import ANY, MACHINE_ROWS, filled, row
from openrooms_usd.furniture.joinery.laundry import console, integrated, two_drawers
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import PANELLED, scheme

CATEGORY: Final = BuiltCategory(
    description="a dishwasher",
    size=(0.6, 0.62, 0.86),
    min_size=(0.4, 0.4, 0.45),
    max_size=(0.9, 0.8, 1.1),
    styles={
        "console": Style(console),
        "integrated": Style(integrated, takes=("fronts",)),
        "drawers": Style(two_drawers),
    },
    size_variation=STANDARD,
    fixed=True,
    mass_range=(30, 55),
    words="dish_washer",
    classes=Classes("dishwasher", "otherstructure", "dishwasher"),
    synsets=("03207941",),
    schemes=(
        scheme("enamel", steel="container handle"),
        scheme("steel", grey="frame", black="base", weight=2.0),
        *PANELLED,
    ),
    construction=(
        row("base", filled(400), "weight"),
        *MACHINE_ROWS,
        row(ANY, filled(130), "weight"),
    ),
    joint_damping=JointDamping(1.0, 2.0),
    view_importance=0.5,
)
