"""Cups with toothbrushes and a tube of paste, as they stand at a basin."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import tapered, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import vessel
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube


def _brush(long: float) -> tuple[Mesh, Mesh]:
    """A toothbrush that stands on its end in the origin, and its bristles, to the front."""
    z = long * np.array([0.0, 0.03, 0.4, 0.75, 0.86, 0.97, 1.0])
    radii = [0.003, 0.005, 0.0055, 0.0032, 0.005, 0.0055, 0.003]
    stick = tube(np.stack([0 * z, 0 * z, z], axis=1), radii, segments=8)
    flat = stick.transformed(np.diag([1.0, 0.7, 1.0]))
    bristles = board((-0.0045, -0.0135, 0.86 * long), (0.0045, -0.002, 0.985 * long), 0.0012)
    return flat, bristles


def _leaning(size: Size, wall: float, count: int, rng: np.random.Generator) -> Parts:
    """Brushes that lean outwards in a cup, heads up."""
    sticks: list[Mesh] = []
    heads: list[Mesh] = []
    r = 0.5 * size[1] - wall - 0.008
    lean = float(np.degrees(np.arctan2(0.5 * size[0] - 0.0095 + 0.2 * r, size[2])))
    for k in range(count):
        long = (size[2] - 0.009) / np.cos(np.radians(lean))
        long *= 1.0 if k == 0 else float(rng.uniform(0.96, 1.0))
        heading = (90.0, -90.0, 70.0)[k]
        a = np.radians(heading)
        place = (-0.2 * r * np.sin(a), 0.2 * r * np.cos(a), 0.008)
        stick, head = (
            turned(turned(mesh, "x", lean), "z", heading).moved(place) for mesh in _brush(long)
        )
        sticks.append(stick)
        heads.append(head)
    return {**numbered("brush", sticks), "bristle": joined(heads)}


def tumbler(size: Size, rng: np.random.Generator) -> Parts:
    """Two brushes in a cup."""
    r, cup = 0.5 * min(size[0], size[1]), 0.52 * size[2]
    wall = 0.003
    profile = [
        (0.0, 0.0),
        (0.88 * r, 0.0),
        (0.9 * r, 0.002),
        (r, cup - 0.001),
        (r - 0.5 * wall, cup),
        (r - wall, cup - 0.001),
        (0.88 * r - wall, 0.006),
        (0.0, 0.006),
    ]
    return {"container": lathe(profile, segments=30, crease=50.0), **_leaning(size, wall, 2, rng)}


def family(size: Size, rng: np.random.Generator) -> Parts:
    """Three brushes and a tube of paste in a square beaker."""
    cup, wall = 0.5 * size[2], 0.004
    x = y = 0.5 * size[1]
    beaker = vessel(
        (-x, -y, 0.0, x, y, cup),
        (-x + wall, -y + wall, 0.006, x - wall, y - wall),
        wall_edge=0.001,
        corner=0.012,
        inner_corner=0.009,
    )
    paste = board((-0.018, -0.014, 0.012), (0.018, 0.014, 0.8 * size[2]), 0.005)
    cap = cylinder(0.011, 0.016, segments=16, base=(0.0, 0.0, 0.008))
    tube_ = tapered(paste, "z", (1.15, 0.18))
    return {"container": beaker, **_leaning(size, wall + 0.004, 3, rng), "tube": tube_, "cap": cap}


CATEGORY: Final = BuiltCategory(
    description="a cup with toothbrushes",
    size=(0.095, 0.072, 0.19),
    min_size=(0.04, 0.04, 0.1),
    max_size=(0.2, 0.2, 0.3),
    styles={"tumbler": Style(tumbler), "family": Style(family, size=(0.1, 0.08, 0.2))},
    support="surface",
    mass_range=(0.08, 0.6),
    words="toothbrush toothbrush_holder toothbrushes",
    schemes=(scheme("porcelain", toy_plastic="brush", plastic="bristle cap", package="tube"),),
    construction=(
        row("container", solid(), "common", "specular_stone"),
        row(ANY, filled(900), "common"),
    ),
    placements=(
        on("basin_edge", "bathroom", cluster="teeth", max_groups=1),
        on("shelf", "bathroom", weight=0.3, max_groups=1),
    ),
)
