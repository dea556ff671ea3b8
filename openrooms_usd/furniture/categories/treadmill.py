"""Treadmills: a belt between two rails, a console on uprights."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.boards import SIDE, board, profiled
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.sweeps import tube


def running(size: Size, rng: np.random.Generator) -> Parts:
    """The belt rises a little to the motor's hood; the console is at the back."""
    width, depth, height = size
    x, front, back = 0.5 * width, -0.5 * depth, 0.5 * depth
    deck = 0.16
    hood = [
        (back - 0.42, 0.05),
        (back - 0.06, 0.0),
        (back, 0.02),
        (back, 0.14),
        (back - 0.1, 0.26),
        (back - 0.34, 0.27),
        (back - 0.42, deck + 0.01),
    ]
    rails = [
        profiled(
            [(front, 0.0), (back - 0.1, 0.05), (back - 0.1, deck + 0.035), (front, 0.09)],
            0.09,
            SIDE,
            0.006,
        ).moved((s * (x - 0.045), 0.0, 0.0))
        for s in (-1.0, 1.0)
    ]
    belt = profiled(
        [
            (front + 0.02, 0.04),
            (back - 0.38, 0.09),
            (back - 0.38, deck + 0.005),
            (front + 0.02, 0.075),
        ],
        width - 0.19,
        SIDE,
        0.004,
    )
    posts, y = [], back - 0.25
    top = height - 0.12
    for s in (-1.0, 1.0):
        path = [
            (s * (x - 0.03), y, 0.06),
            (s * (x - 0.03), y - 0.06, top),
            (s * (x - 0.03), y - 0.45, top - 0.1),
        ]
        posts.append(tube(path, 0.028, bend=0.12, bend_segments=6, segments=14))
    console = profiled(
        [(y - 0.12, top - 0.04), (y + 0.02, top - 0.02), (y + 0.08, height), (y + 0.03, height)],
        width - 0.06,
        SIDE,
        0.004,
    )
    screen = profiled(
        [
            (y - 0.06, top + 0.012),
            (y + 0.004, height - 0.035),
            (y + 0.02, height - 0.03),
            (y - 0.03, top + 0.01),
        ],
        0.3,
        SIDE,
        0.001,
    )
    return {
        "base": profiled(hood, width - 0.02, SIDE, 0.008),
        **numbered("rail", rails),
        "belt": belt,
        **numbered("frame", posts),
        "panel": console,
        "screen": screen,
        "foot": board((0.02 - x, front + 0.05, 0.0), (x - 0.02, front + 0.12, 0.03)),
    }


CATEGORY: Final = BuiltCategory(
    description="a treadmill",
    size=(0.8, 1.75, 1.4),
    min_size=(0.5, 1.1, 0.9),
    max_size=(1.1, 2.3, 1.8),
    styles={"running": Style(running)},
    size_variation=STANDARD,
    one_variant_per_room=True,
    mass_range=(45, 150),
    words="running_machine exercise_machine elliptical",
    classes=Classes(nyu40="otherfurniture"),
    schemes=(
        scheme("dark_plastic", grey="frame rail", tyre="belt"),
        scheme("dark_plastic", black="frame", tyre="belt"),
    ),
    construction=(
        row("base", filled(700), "weight"),
        row("rail belt", filled(500), "weight"),
        row("frame", walls(2.5, STEEL), "sheet"),
        row(ANY, filled(400), "weight"),
    ),
)
