"""Grilles of heating and ventilation in a wall."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.library.furniture.built import (
    NEVER_WEIGHED,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, board
from openrooms_usd.library.furniture.posing import turned

_RIM_M: Final = 0.018
_PITCH_M: Final = 0.013


def louvred(size: Size, rng: np.random.Generator) -> Parts:
    """Slats aslant in a frame."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    clear = x - _RIM_M + 0.002
    frame = [
        board((-x, -y, 0.0), (x, y, _RIM_M), 0.001),
        board((-x, -y, height - _RIM_M), (x, y, height), 0.001),
        *(board((min(s * x, s * (x - _RIM_M)), -y, _RIM_M - 0.002),
                (max(s * x, s * (x - _RIM_M)), y, height - _RIM_M + 0.002), 0.001)
          for s in (-1.0, 1.0)),
    ]  # fmt: skip
    count = max(2, int((height - 2 * _RIM_M) / _PITCH_M))
    slats = []
    for z in np.linspace(_RIM_M, height - _RIM_M, count + 1)[1:-1].tolist():
        slat = board((-clear, -0.7 * y, z - 0.0008), (clear, 0.5 * y, z + 0.0008), 0.0)
        slats.append(turned(slat, "x", 25.0, (0.0, 0.0, z)))
    back = board((-clear, y - 0.002, _RIM_M - 0.002), (clear, y, height - _RIM_M + 0.002), 0.0)
    return {"frame": joined(frame), "slat": joined(slats), "cavity": back}


STYLES: Final = {"louvred": Style(louvred)}


CATEGORY: Final = BuiltCategory(
    description="a grille of heating or ventilation in a wall",
    size=(0.35, 0.014, 0.16),
    least=(0.1, 0.008, 0.08),
    most=(1.2, 0.06, 1.0),
    styles=STYLES,
    spread=STANDARD,
    round=False,
    alike=True,
    support="wall",
    also=(),
    level=0.15,
    lumen=NO_LAMP,
    weighs=NEVER_WEIGHED,
    worktop=NO_APPLIANCE,
    fixed=True,
    words="vent air_vent air_register ventilation_grille duct_vent",
    classes=Classes(UNLABELED, "otherstructure", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "white", "cavity": "soot"}, weight=3.0),
        Scheme({ANY: "steel", "cavity": "soot"}),
    ),
    makes=(makes.row(ANY, makes.walls(1.0), "sheet"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
