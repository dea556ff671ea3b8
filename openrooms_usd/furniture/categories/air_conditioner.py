"""Air conditioners: the long indoor unit high on a wall."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import SIDE, board, profiled
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme


def split(size: Size, rng: np.random.Generator) -> Parts:
    """A rounded case; a flap and louvres below."""
    width, depth, height = size
    y = 0.5 * depth
    outline = [
        (y, 0.0),
        (y, height),
        (0.1 * depth - y, height),
        (-y, 0.86 * height),
        (-y, 0.3 * height),
        (-0.55 * y, 0.06 * height),
        (0.2 * y, 0.0),
    ]
    case = profiled(outline, width, SIDE, 0.012)
    flap = profiled(
        [
            (-0.93 * y, 0.27 * height),
            (-0.5 * y, 0.045 * height),
            (-0.46 * y, 0.06 * height),
            (-0.9 * y, 0.3 * height),
        ],
        0.86 * width,
        SIDE,
        0.001,
    )
    grille = [
        board(
            (-0.46 * width, 0.12 * depth + 0.03 * depth * i - 0.3 * depth, height - 0.003),
            (0.46 * width, 0.13 * depth + 0.03 * depth * i - 0.3 * depth, height + 0.0),
            0.0005,
        )
        for i in range(10)
    ]
    light = board(
        (0.34 * width, -y - 0.0005, 0.4 * height), (0.36 * width, 0.01 - y, 0.44 * height), 0.0004
    )
    return {"frame": case, "louver": flap, **numbered("slat", grille), "screen": light}


CATEGORY: Final = BuiltCategory(
    description="the indoor unit of an air conditioner",
    size=(0.85, 0.21, 0.3),
    min_size=(0.5, 0.12, 0.18),
    max_size=(1.4, 0.4, 0.5),
    styles={"split": Style(split)},
    size_variation=STANDARD,
    support="wall",
    mount_height=2.05,
    fixed=True,
    mass_range=(6, 20),
    words="air_conditioning ac_unit air_condition aircon",
    schemes=(scheme("plastic", grey="slat"),),
    construction=(row(ANY, filled(260), "weight"),),
)
