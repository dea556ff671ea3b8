"""Pairs of shoes: trainers, boots, slippers."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.sweeps import extrude, sheet, tube
from openrooms_usd.geometry.uv import metric
from openrooms_usd.geometry.vectors import points_at

# The sole of a left shoe: half widths to its inner and outer side by the share of its length.
_SOLE: Final = (
    (0.0, 0.12, 0.12),
    (0.04, 0.24, 0.24),
    (0.15, 0.32, 0.32),
    (0.4, 0.27, 0.33),
    (0.62, 0.4, 0.44),
    (0.78, 0.45, 0.43),
    (0.9, 0.4, 0.3),
    (0.97, 0.26, 0.14),
    (1.0, 0.12, 0.04),
)


def _outline(width: float, long: float) -> Array:
    """(N, 2) the outline of a sole, its heel at the back, counter-clockwise."""
    t, inner, outer = np.array(_SOLE).T
    y = 0.5 * long - long * t
    right = points_at(width * inner, y)
    left = points_at(-width * outer, y)
    return np.concatenate([left, right[::-1]])


Row = tuple[float, float, float, float, float]
"""Scale across and along, shift to the heel, and heights there and at the toe, as shares."""


def _shoe(size: Size, rows: Sequence[Row], sole: float) -> Parts:
    """A shoe through outlines that lie above each other, on its sole."""
    width, long, height = size
    shape = _outline(width / 0.9, long)
    rings = []
    for a, b, shift, heel, toe in rows:
        share = (0.5 * long - shape[:, 1]) / long
        flat = shape * [a, b] + [0.0, shift * long]
        toes = np.clip(share * 1.15 - 0.1, 0.0, 1.0) ** 0.8
        z = sole + (height - sole) * (heel + (toe - heel) * toes)
        rings.append(np.column_stack([flat, z]))
    steps = ((0.97, 0.0), (1.0, 0.003), (1.0, sole), (0.96, sole + 0.001))
    base = [ring(shape * s, z) for s, z in steps]
    return {
        "shoe": metric(loft(np.array(rings), crease=60.0))[0],
        "sole": metric(loft(np.array(base)))[0],
    }


def _pair(
    size: Size, rows: Sequence[Row], sole: float, rng: np.random.Generator, laces: bool
) -> Parts:
    """A left and a right shoe beside each other."""
    width, depth, height = size
    one = (0.44 * width, depth, height)
    left = _shoe(one, rows, sole)
    if laces:
        bars = [
            tube(
                [(-0.2 * one[0], y * depth, z * height), (0.2 * one[0], y * depth, z * height)],
                0.0022,
                segments=6,
            )
            for y, z in ((0.12, 0.86), (0.05, 0.77), (-0.02, 0.69), (-0.09, 0.61))
        ]
        left["lace"] = joined(bars)
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    found: Parts = {}
    for name, mesh in left.items():
        found[f"{name}_0"] = mesh.moved((-0.28 * width, 0.0, 0.0))
        found[f"{name}_1"] = mesh.transformed(mirror).moved((0.28 * width, 0.0, 0.0))
    return found


def trainers(size: Size, rng: np.random.Generator) -> Parts:
    """Low shoes with laces."""
    rows = (
        (0.95, 0.97, 0.0, 0.0, 0.0),
        (0.97, 0.97, 0.0, 0.25, 0.14),
        (0.86, 0.9, 0.02, 0.55, 0.36),
        (0.62, 0.72, 0.1, 0.85, 0.56),
        (0.5, 0.42, 0.25, 1.0, 0.86),
        (0.42, 0.36, 0.25, 1.0, 0.88),
        (0.4, 0.33, 0.26, 0.5, 0.45),
    )
    return _pair(size, rows, 0.2 * size[2], rng, laces=True)


def boots(size: Size, rng: np.random.Generator) -> Parts:
    """Boots with a shaft."""
    rows = (
        (0.95, 0.97, 0.0, 0.0, 0.0),
        (0.97, 0.97, 0.0, 0.14, 0.1),
        (0.88, 0.9, 0.02, 0.3, 0.22),
        (0.66, 0.66, 0.14, 0.48, 0.34),
        (0.6, 0.42, 0.26, 0.62, 0.58),
        (0.66, 0.44, 0.26, 1.0, 0.98),
        (0.6, 0.38, 0.26, 1.0, 0.98),
        (0.56, 0.34, 0.26, 0.6, 0.6),
    )
    return _pair(size, rows, 0.1 * size[2], rng, laces=False)


def slippers(size: Size, rng: np.random.Generator) -> Parts:
    """Slippers open at the heel."""
    width, depth, height = size
    one, parts = (0.44 * width, depth, height), {}
    shape = _outline(one[0] / 0.9, depth)
    for k, side in enumerate((-1.0, 1.0)):
        flip = np.diag([-side, 1.0, 1.0, 1.0])
        sole = extrude(shape, 0.3 * height, bevel=0.002).transformed(flip)
        y = np.linspace(-0.44 * depth, 0.02 * depth, 7)
        u = np.linspace(-1.0, 1.0, 9)
        half = np.interp(y, shape[len(_SOLE) :, 1], shape[len(_SOLE) :, 0]) * 0.97
        arch = np.sqrt(np.clip(1.0 - u**2, 0.0, 1.0)) ** 0.8
        rise = np.linspace(0.45, 1.0, 7) * 0.72 * height
        grid = points_at(half[:, None] * u, y[:, None], 0.27 * height + rise[:, None] * arch)
        upper = sheet(grid, 0.004).transformed(flip)
        at = (side * 0.28 * width, 0.0, 0.0)
        parts[f"sole_{k}"], parts[f"shoe_{k}"] = sole.moved(at), upper.moved(at)
    return parts


CATEGORY: Final = BuiltCategory(
    description="a pair of shoes",
    size=(0.24, 0.29, 0.115),
    min_size=(0.12, 0.12, 0.04),
    max_size=(0.5, 0.45, 0.6),
    styles={
        "trainers": Style(trainers, lambda size: 0.08 < size[2] < 0.18),
        "boots": Style(boots, lambda size: size[2] > 0.16, (0.24, 0.29, 0.26)),
        "slippers": Style(slippers, lambda size: size[2] < 0.1, (0.24, 0.28, 0.075)),
    },
    alternative_supports=("surface",),
    mass_range=(0.2, 2.2),
    words="shoe pair_of_shoes sneakers slippers boots boot trainers flops",
    classes=Classes(nyu40="clothes", ade20k="apparel"),
    schemes=(
        scheme("shoe_upper", white_sole="sole lace", weight=2.0),
        scheme("shoe_leather", membrane="sole lace"),
    ),
    construction=(row("sole", filled(500), "common"), row(ANY, filled(140), "weight")),
    placements=(
        on("floor_by_door", count=(1, 3), cluster="shoes", max_groups=3, styles="trainers boots"),
        on("floor_beside_bed", styles="slippers", weight=0.7, max_groups=1),
        on("low_shelf", "hallway", pose="row", count=(1, 3), weight=0.8),
        on(
            "floor_by_wall floor_corner", "bedroom living_room", clutter=3, weight=0.3, max_groups=1
        ),
        on("wardrobe_shelf", weight=0.4, count=(1, 2), pose="row"),
    ),
)
