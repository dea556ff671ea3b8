"""Napkins: folded flat, and in a ring."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.linens import folded_pile, rolled
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import band, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.uv import metric

# Half the length of a ring, metres, and how thick the roll is in it, as a share of its ends.
_HALF_RING_M: Final = 0.012
_WAIST_SHARE: Final = 0.8


def folded(size: Size, rng: np.random.Generator) -> Parts:
    """A napkin folded into a rectangle."""
    return {"cloth": folded_pile(size, 2, rng)}


def ringed(size: Size, rng: np.random.Generator) -> Parts:
    """A napkin rolled and drawn through a ring."""
    _, depth, height = size
    roll = _waisted(rolled(size, rng, columns=9), size)
    inner = _WAIST_SHARE * 0.5 * height
    outer, half = inner + 0.002, _HALF_RING_M
    hoop = band(inner, outer, -half, half, 28)
    laid = turned(hoop, "y", 90.0).transformed(np.diag([1.0, depth / height, 1.0]))
    return {"cloth": roll, "ring": laid.moved((0.0, 0.0, 0.5 * height))}


def _waisted(roll: Mesh, size: Size) -> Mesh:
    """A roll drawn together where the ring is; it lies on its ends, which are flat below."""
    width, _, height = size
    x, y, z = roll.points.T
    out = np.clip((np.abs(x) - _HALF_RING_M) / (0.5 * width - _HALF_RING_M), 0.0, 1.0)
    share = _WAIST_SHARE + (1.0 - _WAIST_SHARE) * out * (2.0 - out)
    points = np.stack([x, share * y, 0.5 * height + share * (z - 0.5 * height)], axis=1)
    return metric(with_normals(replace(roll, points=points), crease=60.0))[0]


CATEGORY: Final = BuiltCategory(
    description="a napkin",
    size=(0.1, 0.2, 0.008),
    min_size=(0.05, 0.02, 0.003),
    max_size=(0.4, 0.4, 0.08),
    styles={
        "folded": Style(folded, lambda size: size[2] < 0.3 * size[1]),
        "ringed": Style(ringed, lambda size: size[2] >= 0.3 * size[1], (0.2, 0.045, 0.045)),
    },
    one_variant_per_room=True,
    lies_under=True,
    support="surface",
    mass_range=(0.005, 0.15),
    words="napkins serviette",
    schemes=(scheme("table_linen", metal="ring"),),
    construction=(row("ring", solid(), "common", "metal"), row(ANY, filled(180), "common")),
    placements=(
        on("dining_table", cluster="setting", weight=0.6),
        on(
            "drawer",
            "kitchen dining_room",
            styles="folded",
            pose="stacked",
            count=(3, 6),
            weight=0.4,
        ),
    ),
)
