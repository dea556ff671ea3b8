"""Keyboards of computers."""

from typing import Final

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.computing import keyboard_full, keyboard_slim, keyboard_split
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

CATEGORY: Final = BuiltCategory(
    description="the keyboard of a computer",
    size=(0.44, 0.14, 0.03),
    min_size=(0.2, 0.08, 0.02),
    max_size=(0.6, 0.26, 0.07),
    styles={
        "full": Style(keyboard_full, lambda size: size[0] > 0.36),
        "slim": Style(keyboard_slim, lambda size: size[0] <= 0.36, (0.3, 0.12, 0.022)),
        "split": Style(keyboard_split, lambda size: size[0] > 0.36, (0.46, 0.17, 0.03)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="surface",
    mass_range=(0.2, 1.2),
    words="computer_keyboard keypad",
    classes=Classes(openrooms45="computer_keyboard", coco="keyboard"),
    synsets=("03085013",),
    schemes=(
        scheme("black_plastic", membrane="key", weight=2.0),
        scheme("aluminium", pale_plastic="key"),
        scheme("pale_plastic"),
    ),
    construction=(row(ANY, filled(500), "weight"),),
)
