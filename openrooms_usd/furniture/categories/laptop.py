"""Laptops: slim, thick, and tablets with a keyboard."""

from typing import Final

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.computing import laptop_classic, laptop_slim, laptop_tablet
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import scheme

CATEGORY: Final = BuiltCategory(
    description="an open laptop; its lid turns",
    size=(0.33, 0.3, 0.22),
    min_size=(0.2, 0.16, 0.12),
    max_size=(0.5, 0.5, 0.4),
    styles={
        "slim": Style(laptop_slim),
        "classic": Style(laptop_classic, size=(0.36, 0.34, 0.25)),
        "tablet": Style(laptop_tablet, size=(0.29, 0.3, 0.2)),
    },
    one_variant_per_room=True,
    support="surface",
    mass_range=(1, 3.5),
    words="laptop_computer notebook",
    classes=Classes("laptop", "otherprop", "computer", "laptop"),
    synsets=("03642806",),
    schemes=(
        scheme("aluminium", black_plastic="hinge key", weight=2.0),
        scheme("dark_plastic", membrane="touchpad key"),
    ),
    construction=(
        row("screen", solid(2500), "common"),
        row("lid", filled(600), "weight"),
        row(ANY, filled(1050), "weight"),
    ),
    joint_damping=JointDamping(0.05, 0.8),
    placements=(
        on("coffee_table dining_table", clutter=2, weight=0.3, max_groups=1),
        on("desk", "office conference_room library", weight=0.4),
    ),
)
