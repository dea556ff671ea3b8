"""Racks that dishes dry in."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, row, solid, walls
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import vessel
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.sweeps import tube


def wire(size: Size, rng: np.random.Generator) -> Parts:
    """A basket of wire with combs for plates over a drip tray."""
    width, depth, height = size
    x, y, r = 0.5 * width, 0.5 * depth, 0.003
    tray = vessel(
        (-x, -y, 0.0, x, y, 0.02), (0.012 - x, 0.012 - y, 0.004, x - 0.012, y - 0.012), corner=0.02
    )
    a, b, low = x - 0.02, y - 0.02, 0.03
    wires = [
        tube([(-a, -b, z), (a, -b, z), (a, b, z), (-a, b, z)], r, segments=8, closed=True)
        for z in (low, height - r)
    ]
    for u in np.linspace(-a, a, max(5, round(width / 0.035))).tolist():
        wires.append(
            tube(
                [(u, -b, height - r), (u, -b, low), (u, b, low), (u, b, height - r)],
                0.6 * r,
                segments=5,
            )
        )
        if u < 0.3 * a:
            wires.append(
                tube([(u, -0.25 * b, low), (u, -0.2 * b, 0.75 * height)], 0.6 * r, segments=5)
            )
    feet = [
        tube([(s * a, t * b, 0.004), (s * a, t * b, low)], r, segments=6)
        for s in (-1.0, 1.0)
        for t in (-1.0, 1.0)
    ]
    return {"tray": tray, "rack": joined([*wires, *feet])}


CATEGORY: Final = BuiltCategory(
    description="a rack that dishes dry in",
    size=(0.42, 0.32, 0.13),
    min_size=(0.25, 0.2, 0.08),
    max_size=(0.7, 0.5, 0.4),
    styles={"wire": Style(wire)},
    size_variation=STANDARD,
    support="surface",
    mass_range=(0.3, 3),
    words="dishrack dish_drainer drying_rack_for_dishes plate_rack",
    schemes=(scheme("chrome", plastic="tray"), scheme("black", dark_plastic="tray", black="rack")),
    construction=(row("tray", walls(2.0, 1000), "common"), row(ANY, solid(STEEL), "common")),
    placements=(on("sink_edge", "kitchen apartment", weight=0.8, max_groups=1, cluster="washing"),),
)
