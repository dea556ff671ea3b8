"""Remote controls: a long one full of keys, and a short one with a ring."""

from functools import partial
from typing import Final

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.handheld import keyed
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

CATEGORY: Final = BuiltCategory(
    description="a remote control",
    size=(0.047, 0.2, 0.022),
    min_size=(0.02, 0.08, 0.008),
    max_size=(0.1, 0.35, 0.05),
    styles={
        "full": Style(partial(keyed, rows=11, ring=False)),
        "slim": Style(partial(keyed, rows=5, ring=True), size=(0.038, 0.145, 0.016)),
    },
    size_variation=STANDARD,
    max_per_room=2,
    support="surface",
    mass_range=(0.04, 0.25),
    words="remote tv_remote remotes controller",
    classes=Classes(coco="remote"),
    synsets=("04074963",),
    schemes=(
        scheme("black_plastic", dark_plastic="button", toy_plastic="switch", weight=3.0),
        scheme("plastic", grey="button", toy_plastic="switch"),
    ),
    construction=(row(ANY, filled(750), "weight"),),
    placements=(
        on(
            "coffee_table media_top",
            "living_room bedroom",
            pose="flat",
            count=(1, 2),
            cluster="media",
        ),
        on(
            "sofa_arm sofa_seat armchair_seat side_table",
            pose="flat",
            clutter=2,
            weight=0.5,
            max_groups=1,
        ),
        on("bedside", pose="flat", weight=0.2, max_groups=1),
    ),
)
