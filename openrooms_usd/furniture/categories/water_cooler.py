"""Water coolers: a column with taps and a bottle upside down on it."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube


def bottled(size: Size, rng: np.random.Generator) -> Parts:
    """A clear bottle of 19 litres on a white column."""
    width, depth, height = size
    x, front, back = 0.5 * width, 0.035 - 0.5 * depth, 0.5 * depth
    top = height - 0.38
    r = min(0.135, 0.46 * width)
    profile = [
        (0.0, 0.0),
        (0.03, 0.0),
        (0.03, 0.05),
        (0.6 * r, 0.085),
        (r, 0.12),
        (r, 0.19),
        (0.96 * r, 0.2),
        (0.96 * r, 0.21),
        (r, 0.22),
        (r, 0.3),
        (0.96 * r, 0.31),
        (0.96 * r, 0.32),
        (r, 0.33),
        (0.92 * r, 0.4),
        (0.0, 0.41),
    ]
    middle = 0.5 * (front + back)
    jar = lathe(profile, segments=40).moved((0.0, middle, height - 0.41))
    niche = top - 0.3
    z = top - 0.1
    taps = [
        tube(
            [
                (s * 0.05, front + 0.05, z),
                (s * 0.05, front - 0.025, z),
                (s * 0.05, front - 0.028, z - 0.03),
            ],
            0.008,
            segments=10,
        )
        for s in (-1.0, 1.0)
    ]
    return {
        **numbered(
            "frame",
            [
                board((-x, front, 0.0), (x, back, niche), 0.012),
                board((-x, front + 0.03, niche - 0.005), (x, back, top), 0.012),
            ],
        ),
        "panel": board(
            (-0.8 * x, front - 0.003, 0.06), (0.8 * x, front + 0.01, niche - 0.06), 0.004
        ),
        "tray": board(
            (-0.6 * x, front + 0.002, niche - 0.006), (0.6 * x, front + 0.06, niche + 0.012), 0.003
        ),
        **numbered("spout", taps),
        "bottle": jar,
    }


CATEGORY: Final = BuiltCategory(
    description="a water cooler with its bottle",
    size=(0.31, 0.35, 1.32),
    min_size=(0.24, 0.25, 0.9),
    max_size=(0.45, 0.5, 1.6),
    styles={"bottled": Style(bottled)},
    size_variation=STANDARD,
    mass_range=(15, 60),
    words="water_dispenser water_fountain",
    classes=Classes(nyu40="otherfurniture"),
    schemes=(
        scheme("plastic", dark_plastic="tray", tinted_plastic="spout", water_bottle="bottle"),
    ),
    construction=(row("bottle", filled(900), "common"), row(ANY, filled(180), "weight")),
)
