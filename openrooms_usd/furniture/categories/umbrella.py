"""Umbrellas, rolled up."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid, walls
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric
from openrooms_usd.geometry.vectors import points_at


def _canopy(r: float, low: float, high: float, rng: np.random.Generator) -> Mesh:
    """Cloth wound about the stick, in folds that taper to its tip."""
    count, rows = 24, 8
    angle = 2.0 * np.pi * np.arange(count) / count
    rings = []
    for t in np.linspace(0.0, 1.0, rows).tolist():
        wide = (
            1.12
            * r
            * (0.16 + 0.84 * np.sin(0.5 * np.pi * min(1.0, 1.25 * t)))
            * (1.0 - 0.25 * t**4)
        )
        fold = wide * (1.0 + 0.16 * np.cos(8.0 * angle + 2.4 * t))
        rings.append(
            points_at(
                fold * np.cos(angle) / 1.16, fold * np.sin(angle) / 1.16, low + (high - low) * t
            )
        )
    tip = np.full(count, high + 0.004)
    rings.append(points_at(0.006 * np.cos(angle), 0.006 * np.sin(angle), tip))
    return metric(loft(np.array(rings), crease=60.0))[0]


def rolled_up(size: Size, rng: np.random.Generator) -> Parts:
    """A long umbrella on its tip, its handle hooked to the side."""
    width, depth, height = size
    r = 0.5 * depth
    crook = 0.5 * (width - r - 0.009)
    x = 0.5 * width - r
    top = height - crook - 0.009
    t = np.radians(np.linspace(0.0, 200.0, 9))
    hook = points_at(-crook + crook * np.cos(t), 0.0, top + crook * np.sin(t))
    grip = tube(np.concatenate([[(0.0, 0.0, top - 0.1)], hook]), 0.009, segments=8)
    stick = cylinder(0.0045, top - 0.05, segments=10)
    body = _canopy(r, 0.06, top - 0.16, rng)
    move = (x, 0.0, 0.0)
    return {"canopy": body.moved(move), "stick": stick.moved(move), "handle": grip.moved(move)}


CATEGORY: Final = BuiltCategory(
    description="a rolled-up umbrella",
    size=(0.15, 0.08, 0.88),
    min_size=(0.06, 0.04, 0.2),
    max_size=(0.4, 0.3, 1.2),
    styles={"rolled": Style(rolled_up)},
    alternative_supports=("wall",),
    mass_range=(0.3, 1.2),
    words="umbrellas parasol",
    classes=Classes(coco="umbrella"),
    schemes=(scheme("coat_cloth", steel="stick", wood="handle"),),
    construction=(
        row("canopy", filled(160), "weight"),
        row("stick", walls(1.0), "sheet", "metal"),
        row(ANY, solid(700), "common"),
    ),
    placements=(
        on(
            "floor_by_door floor_corner",
            "hallway living_room",
            pose="leaning",
            weight=0.4,
            max_groups=1,
        ),
    ),
)
