"""Vacuum cleaners on wheels, their tube parked upright behind them."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import cushion, cylinder
from openrooms_usd.geometry.sweeps import tube


def canister(size: Size, rng: np.random.Generator) -> Parts:
    """A rounded body with wheels at its sides, a hose, and a tube on its floor head."""
    width, depth, height = size
    x, y = 0.5 * width, 0.5 * depth
    deep = depth - 0.13
    tall = min(0.26, 0.3 * height)
    middle = deep * 0.5 - y
    body = cushion(
        (0.84 * width, deep, tall - 0.03),
        radius=0.06,
        crown=(0.01, 0.01, 0.02),
        center=(0.0, middle, 0.03 + 0.5 * (tall - 0.03)),
    )
    wheel = turned(cylinder(0.32 * tall, 0.04, bevel=0.008, segments=28), "y", 90.0)
    wheels = [
        wheel.moved((s * x - (0.04 if s > 0 else 0.0), middle + 0.22 * deep, 0.32 * tall))
        for s in (-1.0, 1.0)
    ]
    caster = cylinder(0.025, 0.05, segments=16, base=(0.0, middle - 0.34 * deep, 0.0))
    # The head stands on the floor behind, the tube on it.
    head = board((-0.48 * width, y - 0.1, 0.0), (0.48 * width, y, 0.055), 0.014)
    pipe = tube([(0.0, y - 0.05, 0.045), (0.0, y - 0.05, height - 0.12)], 0.0165, segments=16)
    grip = [
        (0.0, y - 0.05, height - 0.13),
        (0.0, y - 0.05, height - 0.05),
        (0.0, y - 0.12, height - 0.021),
    ]
    end = (0.0, y - 0.12, height - 0.021)
    hose = [
        end,
        (0.02, y - 0.24, height - 0.06),
        (0.3 * width, middle - 0.1 * deep, 0.62 * height),
        (0.24 * width, middle - 0.3 * deep, 0.42 * height),
        (0.0, middle - 0.28 * deep, tall - 0.02),
    ]
    knob = cylinder(
        0.032, 0.012, bevel=0.003, segments=20, base=(0.0, middle + 0.2 * deep, tall + 0.008)
    )
    strap = tube(
        [
            (0.0, middle - 0.14 * deep, tall - 0.01),
            (0.0, middle - 0.12 * deep, tall + 0.035),
            (0.0, middle + 0.08 * deep, tall + 0.035),
            (0.0, middle + 0.1 * deep, tall - 0.01),
        ],
        0.01,
        bend=0.02,
        segments=10,
    )
    return {
        "body": body,
        **numbered("wheel", [*wheels, caster]),
        "base": head,
        "pipe": pipe,
        "hose": tube(hose, 0.0175, bend=0.12, bend_segments=5, segments=14),
        "grip": joined([tube(grip, 0.021, bend=0.05, segments=14), strap]),
        "button": knob,
    }


CATEGORY: Final = BuiltCategory(
    description="a vacuum cleaner",
    size=(0.3, 0.52, 0.98),
    min_size=(0.2, 0.35, 0.6),
    max_size=(0.45, 0.75, 1.3),
    styles={"canister": Style(canister)},
    mass_range=(3, 11),
    words="vacuum hoover vacuum_cleaners floor_cleaner",
    schemes=(
        scheme(
            "black_plastic",
            toiletry="body",
            chrome="pipe",
            tyre="wheel",
            dark_plastic="button",
            black_plastic="grip",
        ),
    ),
    construction=(
        row("pipe", walls(0.8, STEEL), "sheet", "metal"),
        row("hose", walls(1.5, 950), "common"),
        row(ANY, filled(230), "common"),
    ),
    placements=(
        on(
            "floor_by_wall floor_corner",
            "hallway closet laundry_room storage basement apartment",
            weight=0.8,
            max_groups=1,
        ),
        on("floor_corner", "living_room bedroom", clutter=2, weight=0.15, max_groups=1),
    ),
)
