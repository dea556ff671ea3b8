"""Trays to carry things, and coasters below glasses."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import METAL, scheme
from openrooms_usd.geometry.lofts import loft, ring, rounded_rectangle, superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric


def _rimmed(outline: Array, height: float, wall: float, floor: float) -> Mesh:
    """A flat dish with upright sides over an outline about the origin."""
    half = np.abs(outline).max(axis=0)
    inner = outline * (1.0 - wall / half)
    rows = [
        (outline * 0.985, 0.0),
        (outline, 0.003),
        (outline, height - 0.001),
        (outline * (1.0 - 0.3 * wall / half), height),
        (inner * 1.002, height - 0.001),
        (inner, floor + 0.001),
        (inner * 0.99, floor),
    ]
    return metric(loft(np.array([ring(flat, z) for flat, z in rows])))[0]


def rectangular(size: Size, rng: np.random.Generator) -> Parts:
    """A rectangular tray with two handles."""
    width, depth, height = size
    rim = 0.62 * height
    base = _rimmed(rounded_rectangle(width, depth, 0.02), rim, 0.009, 0.007)
    grips = []
    for side in (-1.0, 1.0):
        x = side * (0.5 * width - 0.006)
        path = [
            (x, -0.07, 0.8 * rim),
            (x, -0.07, height - 0.004),
            (x, 0.07, height - 0.004),
            (x, 0.07, 0.8 * rim),
        ]
        grips.append(tube(path, 0.004, bend=0.015, bend_segments=3, segments=8))
    return {"tray": base, **numbered("handle", grips)}


def round_(size: Size, rng: np.random.Generator) -> Parts:
    """A round tray."""
    width, depth, height = size
    return {"tray": _rimmed(superellipse(width, depth), height, 0.006, 0.005)}


CATEGORY: Final = BuiltCategory(
    description="a tray",
    size=(0.44, 0.3, 0.055),
    min_size=(0.12, 0.1, 0.015),
    max_size=(0.8, 0.6, 0.15),
    styles={
        "rectangular": Style(rectangular, lambda size: size[0] > 1.15 * size[1]),
        "round": Style(round_, lambda size: size[0] < 1.2 * size[1], (0.34, 0.34, 0.03)),
    },
    support="surface",
    mass_range=(0.2, 2.5),
    words="trays serving_tray",
    classes=Classes(ade20k="tray"),
    schemes=(
        scheme("wood", metal="handle", weight=2.0),
        scheme(METAL, metal="handle", weight=0.7),
        scheme("lacquer", metal="handle"),
    ),
    construction=(
        row(ANY, solid(1400), "weight", "metal", "paint"),
        row("handle", solid(2000), "common"),
        row(ANY, solid(700), "common"),
    ),
    placements=(
        on("coffee_table", weight=0.5, max_groups=1, pose="flat"),
        on("worktop cabinet_top dresser_top", weight=0.25, max_groups=1, pose="flat"),
        on("bed_foot", clutter=2, weight=0.05, max_groups=1, pose="flat"),
    ),
)
