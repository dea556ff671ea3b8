"""The screens of computers."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import PLAIN_HINGES, RIGID, Classes
from openrooms_usd.categories.schemes import SCREENS, Scheme
from openrooms_usd.library.furniture.built import HANGS_NOT, NO_APPLIANCE, NO_LAMP, BuiltCategory
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.screen import deep, monitor_curved, monitor_flat, monitor_tube

CATEGORY: Final = BuiltCategory(
    description="the screen of a computer",
    size=(0.56, 0.2, 0.42),
    least=(0.25, 0.1, 0.22),
    most=(1.3, 0.6, 0.9),
    styles={
        "flat": Style(monitor_flat, lambda size: not deep(size)),
        "curved": Style(
            monitor_curved, lambda size: size[0] > 0.5 and not deep(size), (0.81, 0.24, 0.46)
        ),
        "tube": Style(monitor_tube, deep, (0.42, 0.42, 0.42)),
    },
    spread=(0.15, 0.0, 0.1),
    round=False,
    alike=True,
    support="surface",
    also=("wall",),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (3, 8), "tube": (12, 32)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="computer_monitor screen computer_screen display lcd",
    classes=Classes("monitor", "otherprop", "monitor", "tv"),
    synsets=("03211117",),
    schemes=(
        *SCREENS,
        Scheme({ANY: "pale_plastic", "button": "pale_plastic"}, needs="button", weight=100.0),
    ),
    makes=(
        makes.row("screen", makes.solid(2500), "common"),
        makes.row(ANY, makes.filled(300), "weight"),
        makes.row("stand base foot", makes.filled(3000), "weight"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    photographed=1.0,
)
