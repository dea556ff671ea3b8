"""Bathroom scales."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.boards import board, corners
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import rounded_rectangle
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import extrude


def _feet(size: Size, high: float) -> Parts:
    places = corners(0.38 * size[0], 0.38 * size[1])
    return numbered(
        "foot", [cylinder(0.02, high, segments=16, base=(x, y, 0.0)) for x, y in places]
    )


def glass(size: Size, rng: np.random.Generator) -> Parts:
    """A thin plate with a small display and four contacts of steel."""
    width, depth, height = size
    plate = extrude(
        rounded_rectangle(width, depth, 0.025, 6), height - 0.0125, bevel=0.0015, base=0.012
    )
    top = height - 0.0008
    shown = board((-0.045, 0.3 * depth, top - 0.001), (0.045, 0.3 * depth + 0.032, height), 0.0002)
    pads = [
        cylinder(0.026, 0.0013, segments=24, base=(x, y, top - 0.0005))
        for x, y in corners(0.34 * width, 0.22 * depth)
    ]
    return {"plate": plate, "field": shown, **numbered("contact", pads), **_feet(size, 0.013)}


def dial(size: Size, rng: np.random.Generator) -> Parts:
    """A box of sheet metal with a mat of rubber and a round window."""
    width, depth, height = size
    body = extrude(rounded_rectangle(width, depth, 0.03, 6), height - 0.012, bevel=0.006, base=0.01)
    mat = board(
        (-0.42 * width, -0.44 * depth, height - 0.004), (0.42 * width, 0.16 * depth, height), 0.001
    )
    window = cylinder(
        0.055, 0.003, bevel=0.001, segments=30, base=(0.0, 0.31 * depth, height - 0.0035)
    )
    return {"body": body, "mat": mat, "field": window, **_feet(size, 0.012)}


CATEGORY: Final = BuiltCategory(
    description="bathroom scales",
    size=(0.3, 0.3, 0.026),
    min_size=(0.2, 0.2, 0.018),
    max_size=(0.45, 0.45, 0.09),
    styles={
        "glass": Style(glass, lambda size: size[2] < 0.04),
        "dial": Style(dial, lambda size: size[2] > 0.035, (0.27, 0.29, 0.05)),
    },
    one_variant_per_room=True,
    mass_range=(0.8, 4),
    words="scale bathroom_scale weighing_scale bathroom_scales",
    schemes=(
        scheme("back_painted_glass", dark_plastic="field", chrome="contact", black_plastic="foot"),
        scheme(
            "white",
            tyre="mat",
            white_paper="field",
            black_plastic="foot",
            needs="mat",
            weight=100.0,
        ),
    ),
    construction=(
        row("plate", solid(2000), "common", "specular_stone"),
        row(ANY, filled(500), "common"),
    ),
    placements=(
        on("floor_by_wall floor_corner", "bathroom", pose="flat", weight=2.5, max_groups=1),
    ),
)
