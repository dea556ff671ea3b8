"""Suitcases on wheels: a ribbed hard shell with its handle."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid, walls
from openrooms_usd.furniture.joinery.boards import board, corners
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import tube


def shell(size: Size, rng: np.random.Generator) -> Parts:
    """Two halves with upright ribs on four wheels."""
    width, depth, height = size
    x, y, low, high = 0.5 * width, 0.5 * depth, 0.05, height - 0.02
    rib = 0.006
    seam = 0.004
    halves = [
        board((-x, a, low), (x, b, high), 0.03) for a, b in ((rib - y, -seam), (seam, y - rib))
    ]
    ribs = [
        board(
            (float(a) - 0.012, s, low + 0.07), (float(a) + 0.012, s + 2 * rib, high - 0.07), 0.004
        )
        for a in np.linspace(0.06 - x, x - 0.06, max(4, round(width / 0.06)))
        for s in (-y, y - 2 * rib)
    ]
    wheels = [
        turned(cylinder(0.025, 0.02, bevel=0.004, segments=20), "y", 90.0).moved(
            (a - 0.01, b, 0.025)
        )
        for a, b in corners(x - 0.05, y - 0.06)
    ]
    forks = [
        board((a - 0.016, b - 0.014, 0.03), (a + 0.016, b + 0.014, low + 0.01), 0.003)
        for a, b in corners(x - 0.05, y - 0.06)
    ]
    grip = tube(
        [
            (-0.07, 0.0, high - 0.005),
            (-0.06, 0.0, height - 0.007),
            (0.06, 0.0, height - 0.007),
            (0.07, 0.0, high - 0.005),
        ],
        0.007,
        bend=0.01,
        segments=10,
    )
    zipper = board((0.004 - x, -seam, low + 0.004), (x - 0.004, seam, high - 0.004), 0.02)
    return {
        **numbered("shell", halves),
        **numbered("rib", ribs),
        **numbered("wheel", wheels),
        **numbered("bracket", forks),
        "handle": grip,
        "zipper": zipper,
    }


CATEGORY: Final = BuiltCategory(
    description="a suitcase on wheels",
    size=(0.44, 0.27, 0.66),
    min_size=(0.3, 0.15, 0.4),
    max_size=(0.65, 0.45, 0.95),
    styles={"shell": Style(shell)},
    alternative_supports=("surface",),
    mass_range=(2, 9),
    words="luggage travel_bag trolley_case baggage carry_on",
    classes=Classes("bag", "bag", "bag", "suitcase"),
    schemes=(scheme("luggage_shell", black_plastic="bracket handle zipper"),),
    construction=(
        row("wheel bracket handle", solid(1100), "common"),
        row("rib zipper", filled(150), "common"),
        row(ANY, walls(2.2, 1100), "common"),
    ),
)
