"""Upright pianos: a tall case with its keys, on feet or on consoles."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import box

# Of a keyboard: 52 white keys of 23.5 mm over 1.225 m, their length and level; metres.
_KEYS, _KEYS_M, _KEY_LONG_M, _LEVEL_M = 52, 1.225, 0.15, 0.73
# Which white keys of an octave that begins with A have a black one on their right.
_SHARPS: Final = (True, False, True, True, False, True, True)


def upright(size: Size, rng: np.random.Generator) -> Furniture:
    """A case of lacquered wood; the lid over the keys stands open."""
    width, depth, height = size
    made, x, back, cheek = Assembly(), 0.5 * width, 0.5 * depth, 0.03
    case = back - 0.6 * depth
    made.add(
        "frame",
        *(
            board((a, case, 0.0), (a + cheek, back, height - 0.025), 0.003)
            for a in (-x + 0.01, x - cheek - 0.01)
        ),
        board(
            (cheek + 0.01 - x, case + 0.02, 0.1), (x - cheek - 0.01, case + 0.04, _LEVEL_M - 0.1)
        ),
        board(
            (cheek + 0.01 - x, case + 0.03, _LEVEL_M + 0.1),
            (x - cheek - 0.01, case + 0.05, height - 0.025),
        ),
        board((cheek + 0.01 - x, back - 0.03, 0.1), (x - cheek - 0.01, back, height - 0.025)),
        board((cheek + 0.01 - x, case + 0.02, 0.0), (x - cheek - 0.01, back, 0.1)),
    )
    made.board("lid", (-x, case - 0.01, height - 0.025), (x, back, height), 0.006)
    front = -0.5 * depth
    least, most = (0.012 - x, front, _LEVEL_M - 0.09), (x - 0.012, case + 0.02, _LEVEL_M - 0.03)
    made.board("keybed", least, most, 0.004)
    for a in (-x + 0.01, x - 0.06 - 0.01):
        least, most = (a, front + 0.01, _LEVEL_M - 0.03), (a + 0.06, case + 0.03, _LEVEL_M + 0.06)
        made.board("arm", least, most, 0.01)
        foot = a + 0.01
        made.board(
            "leg", (foot, front + 0.03, 0.0), (foot + 0.04, front + 0.08, _LEVEL_M - 0.09), 0.006
        )
    made.board(
        "fallboard",
        (0.075 - x, case + 0.005, _LEVEL_M - 0.02),
        (x - 0.075, case + 0.022, _LEVEL_M + 0.13),
        0.004,
    )
    _keyboard(made, case, min(_KEYS_M, width - 0.16))
    made.board(
        "desk", (-0.35, case - 0.02, _LEVEL_M + 0.16), (0.35, case - 0.008, height - 0.1), 0.003
    )
    for a in (-0.07, 0.0, 0.07):
        made.board("pedal", (a - 0.011, case - 0.06, 0.05), (a + 0.011, case + 0.03, 0.062), 0.004)
    return made.furniture()


def _keyboard(made: Assembly, case: float, wide: float) -> None:
    """White keys as one part, black ones as another."""
    pitch, near = wide / _KEYS, case - _KEY_LONG_M
    at = (np.arange(_KEYS) + 0.5) * pitch - 0.5 * wide
    white = [
        box(
            (pitch - 0.001, _KEY_LONG_M, 0.02),
            (float(a), near + 0.5 * _KEY_LONG_M, _LEVEL_M - 0.01),
        )
        for a in at
    ]
    black = [
        box((0.011, 0.095, 0.012), (float(a) + 0.5 * pitch, case - 0.0475, _LEVEL_M + 0.006))
        for i, a in enumerate(at[:-1])
        if _SHARPS[i % 7]
    ]
    made.add("keys", joined(white))
    made.add("sharps", joined(black))


CATEGORY: Final = BuiltCategory(
    description="an upright piano",
    size=(1.48, 0.6, 1.2),
    min_size=(1.2, 0.4, 0.95),
    max_size=(1.7, 0.8, 1.45),
    styles={"upright": Style(upright)},
    size_variation=STANDARD,
    mass_range=(170, 300),
    words="upright_piano grand_piano digital_piano keyboard_piano spinet",
    classes=Classes(openrooms45="piano", nyu40="otherfurniture"),
    synsets=("03928116",),
    schemes=(
        scheme("piano_lacquer", ivory="keys", black_plastic="sharps", brass="pedal", weight=2.0),
        scheme("wood", ivory="keys", black_plastic="sharps", brass="pedal"),
    ),
    construction=(
        row("keys sharps", filled(500), "common"),
        # Iron plate, strings and action are not modelled.
        row("frame", filled(1400), "weight"),
        row(ANY, filled(700), "common"),
    ),
    offers_surfaces=("cabinet_top",),
)
