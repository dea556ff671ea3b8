"""Candles: thick ones, a jar of wax, a tall one on its stick."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid, walls
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import band
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import WIDE, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube


def _wick(z: float) -> Mesh:
    path = [(0.0, 0.0, z - 0.002), (0.0, 0.0, z + 0.006), (0.002, 0.0, z + 0.01)]
    return tube(path, 0.0009, segments=6)


def pillar(size: Size, rng: np.random.Generator) -> Parts:
    """A thick candle that has burnt for a while."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    low = h - float(rng.uniform(0.007, 0.011))
    wax = lathe(
        [
            (0.0, 0.0),
            (r - 0.002, 0.0),
            (r, 0.002),
            (r, h - 0.003),
            (r - 0.003, h),
            (r - 0.006, h - 0.001),
            (0.5 * r, low),
            (0.0, low - 0.001),
        ],
        segments=30,
        crease=50.0,
    )
    return {"wax": wax, "wick": _wick(low)}


def jar(size: Size, rng: np.random.Generator) -> Parts:
    """Wax in a glass with a label."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    fill = float(rng.uniform(0.5, 0.75)) * h
    glass = lathe(
        [
            (0.0, 0.0),
            (r - 0.003, 0.0),
            (r, 0.003),
            (r, h - 0.001),
            (r - 0.0015, h),
            (r - 0.003, h - 0.001),
            (r - 0.003, fill),
            (0.0, fill),
        ]
    )
    label = band(r - 0.0004, r + 0.0003, 0.25 * h, 0.6 * h)
    top = cylinder(r - 0.0032, 0.003, segments=28, base=(0.0, 0.0, fill - 0.001))
    return {"container": glass, "label": label, "wax": top, "wick": _wick(fill + 0.002)}


def stick(size: Size, rng: np.random.Generator) -> Parts:
    """A tall candle on a stick."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    foot = float(rng.uniform(0.3, 0.45)) * h
    holder = lathe(
        [
            (0.0, 0.0),
            (r, 0.0),
            (r, 0.004),
            (0.85 * r, 0.008),
            (0.25 * r, 0.02),
            (0.006, 0.03),
            (0.006, foot - 0.03),
            (0.014, foot - 0.024),
            (0.016, foot),
            (0.0, foot),
        ],
        segments=28,
        crease=50.0,
    )
    end = h - 0.01
    wax = lathe(
        [
            (0.0, foot - 0.001),
            (0.0105, foot - 0.001),
            (0.0095, end - 0.006),
            (0.004, end),
            (0.0, end),
        ],
        segments=18,
    )
    return {"base": holder, "wax": wax, "wick": _wick(end)}


CATEGORY: Final = BuiltCategory(
    description="a candle",
    size=(0.075, 0.075, 0.12),
    min_size=(0.03, 0.03, 0.03),
    max_size=(0.25, 0.25, 0.6),
    styles={
        "pillar": Style(pillar, lambda size: size[2] < 3.0 * size[0]),
        "jar": Style(jar, lambda size: size[2] < 1.6 * size[0], (0.08, 0.08, 0.095)),
        "stick": Style(stick, lambda size: size[2] > 2.5 * size[0], (0.09, 0.09, 0.33)),
    },
    size_variation=WIDE,
    round=True,
    max_per_room=5,
    support="surface",
    mass_range=(0.06, 1.2),
    words="candles candlestick candle_holder",
    schemes=(
        scheme("wax", cavity="wick", metal="base"),
        scheme(
            "glaze", wax="wax", cavity="wick", bottle_label="label", needs="label", weight=100.0
        ),
    ),
    construction=(
        row("wax", solid(900), "common"),
        row("base", walls(2), "common", "metal", "paint"),
        row(ANY, solid(1600), "common"),
    ),
    placements=(
        on(
            "coffee_table side_table mantel window_sill shelf bedside",
            weight=0.5,
            count=(1, 3),
            max_variants=3,
            cluster="reading",
        ),
        on("dining_table", styles="stick pillar", count=(1, 2), weight=0.5, max_groups=1),
        on("bath_rim cistern basin_edge", styles="jar pillar", weight=0.3, max_groups=1),
        on("on_tray", styles="jar pillar", weight=0.5, count=(1, 2)),
    ),
)
