"""Grilles of heating and ventilation in a wall."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, walls
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined

_RIM_M: Final = 0.018
_PITCH_M: Final = 0.013


def louvred(size: Size, rng: np.random.Generator) -> Parts:
    """Slats aslant in a frame."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    clear = x - _RIM_M + 0.002
    frame = [
        board((-x, -y, 0.0), (x, y, _RIM_M), 0.001),
        board((-x, -y, height - _RIM_M), (x, y, height), 0.001),
        *(
            board(
                (min(s * x, s * (x - _RIM_M)), -y, _RIM_M - 0.002),
                (max(s * x, s * (x - _RIM_M)), y, height - _RIM_M + 0.002),
                0.001,
            )
            for s in (-1.0, 1.0)
        ),
    ]
    count = max(2, int((height - 2 * _RIM_M) / _PITCH_M))
    slats = []
    for z in np.linspace(_RIM_M, height - _RIM_M, count + 1)[1:-1].tolist():
        slat = board((-clear, -0.7 * y, z - 0.0008), (clear, 0.5 * y, z + 0.0008), 0.0)
        slats.append(turned(slat, "x", 25.0, (0.0, 0.0, z)))
    back = board((-clear, y - 0.002, _RIM_M - 0.002), (clear, y, height - _RIM_M + 0.002), 0.0)
    return {"frame": joined(frame), "slat": joined(slats), "cavity": back}


CATEGORY: Final = BuiltCategory(
    description="a grille of heating or ventilation in a wall",
    size=(0.35, 0.014, 0.16),
    min_size=(0.1, 0.008, 0.08),
    max_size=(1.2, 0.06, 1.0),
    styles={"louvred": Style(louvred)},
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="wall",
    mount_height=0.15,
    fixed=True,
    words="vent air_vent air_register ventilation_grille duct_vent",
    classes=Classes(nyu40="otherstructure"),
    schemes=(scheme("white", soot="cavity", weight=3.0), scheme("steel", soot="cavity")),
    construction=(row(ANY, walls(1.0), "sheet"),),
)
