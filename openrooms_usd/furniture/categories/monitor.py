"""The screens of computers."""

from typing import Final

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.joinery.screen import deep, monitor_curved, monitor_flat, monitor_tube
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import SCREENS, scheme

CATEGORY: Final = BuiltCategory(
    description="the screen of a computer",
    size=(0.56, 0.2, 0.42),
    min_size=(0.25, 0.1, 0.22),
    max_size=(1.3, 0.6, 0.9),
    styles={
        "flat": Style(monitor_flat, lambda size: not deep(size), weight=4.0),
        "curved": Style(
            monitor_curved, lambda size: size[0] > 0.5 and not deep(size), (0.81, 0.24, 0.46)
        ),
        "tube": Style(monitor_tube, deep, (0.42, 0.42, 0.42), mass_range=(12, 32), weight=0.02),
    },
    size_variation=(0.15, 0.0, 0.1),
    one_variant_per_room=True,
    support="surface",
    alternative_supports=("wall",),
    mass_range=(3, 8),
    words="computer_monitor screen computer_screen display lcd",
    classes=Classes("monitor", "otherprop", "monitor", "tv"),
    synsets=("03211117",),
    schemes=(*SCREENS, scheme("pale_plastic", pale_plastic="button", needs="button", weight=100.0)),
    construction=(
        row("screen", solid(2500), "common"),
        row(ANY, filled(300), "weight"),
        row("stand base foot", filled(3000), "weight"),
    ),
    view_importance=1.0,
)
