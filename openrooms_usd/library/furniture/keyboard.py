"""Keyboards of computers."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.computing import keyboard_full, keyboard_slim, keyboard_split
from openrooms_usd.library.furniture.joinery import Style

CATEGORY: Final = BuiltCategory(
    description="the keyboard of a computer",
    size=(0.44, 0.14, 0.03),
    least=(0.2, 0.08, 0.02),
    most=(0.6, 0.26, 0.07),
    styles={
        "full": Style(keyboard_full, lambda size: size[0] > 0.36),
        "slim": Style(keyboard_slim, lambda size: size[0] <= 0.36, (0.3, 0.12, 0.022)),
        "split": Style(keyboard_split, lambda size: size[0] > 0.36, (0.46, 0.17, 0.03)),
    },
    spread=STANDARD,
    round=False,
    alike=True,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.2, 1.2)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="computer_keyboard keypad",
    classes=Classes("computer_keyboard", "otherprop", UNLABELED, "keyboard"),
    synsets=("03085013",),
    schemes=(
        Scheme({ANY: "black_plastic", "key": "membrane"}, weight=2.0),
        Scheme({ANY: "aluminium", "key": "pale_plastic"}),
        Scheme({ANY: "pale_plastic"}),
    ),
    makes=(makes.row(ANY, makes.filled(500), "weight"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
