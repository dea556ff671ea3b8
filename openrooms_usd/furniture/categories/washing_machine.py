"""Washing machines: portholes, lids, one under a dryer, and the dryer beside one."""

from functools import partial
from typing import Final

from openrooms_usd.furniture.construction import ANY, MACHINE_ROWS, filled, row
from openrooms_usd.furniture.joinery.laundry import front_loader, stacked, top_loader
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

CATEGORY: Final = BuiltCategory(
    description="a washing machine",
    size=(0.6, 0.6, 0.86),
    min_size=(0.4, 0.4, 0.55),
    max_size=(0.9, 0.9, 2.1),
    styles={
        "front_loader": Style(front_loader, lambda size: size[2] < 1.3, weight=3.0),
        "top_loader": Style(top_loader, lambda size: size[2] < 1.3, (0.66, 0.66, 1.05)),
        # It stands beside another.
        "dryer": Style(
            partial(front_loader, clear=False),
            lambda size: size[2] < 1.3,
            mass_range=(35, 60),
            weight=0.0,
        ),
        "stacked": Style(
            stacked, lambda size: size[2] >= 1.3, (0.6, 0.62, 1.72), mass_range=(80, 140)
        ),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    mass_range=(55, 90),
    words="washer washer_dryer washing_machines clothes_dryer dryer laundry_machine",
    classes=Classes("washing_machine", "otherfurniture", "washer"),
    synsets=("04554684",),
    schemes=(
        scheme("enamel", chrome="handle", black="base", weight=2.0),
        scheme("enamel", chrome="handle door", black="base", grey="panel"),
        scheme("grey", chrome="handle knob", black="base"),
    ),
    construction=(
        row("drum", filled(8000), "weight"),
        row("top", filled(2000), "weight"),
        *MACHINE_ROWS,
        row(ANY, filled(215), "weight"),
    ),
    offers_surfaces=("appliance_top",),
    view_importance=1.5,
)
