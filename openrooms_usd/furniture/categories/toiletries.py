"""What stands in bathrooms: shampoo, tubes, jars of cream, spray cans."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import band, oval
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.uv import metric

Row = tuple[float, float, float]
# A label is so much thicker than what it is on, metres.
_LABEL_M: Final = 0.0004


def _flat(size: Size, rows: list[Row], power: float, grown: float = 0.0) -> Mesh:
    """A body of flattened rings: shares of width and depth, and heights in metres."""
    rings = [
        ring(superellipse(a * size[0] + grown, b * size[1] + grown, power, 24), z)
        for a, b, z in rows
    ]
    return metric(loft(rings, crease=50.0))[0]


def shampoo(size: Size, rng: np.random.Generator) -> Parts:
    """A flat bottle with rounded shoulders, a lid on top, a label around it."""
    tall = 0.84 * size[2]
    bulge = float(rng.uniform(0.86, 1.0))
    rows = [
        (0.9 * bulge, 0.9, 0.0),
        (bulge, 1.0, 0.05 * tall),
        (1.0, 1.0, 0.5 * tall),
        (bulge, 1.0, 0.86 * tall),
        (0.85 * bulge, 0.85, 0.95 * tall),
        (0.6, 0.6, tall),
    ]
    middle = [(1.0, 1.0, 0.42 * tall), (1.0, 1.0, 0.5 * tall), (1.0, 1.0, 0.58 * tall)]
    lid = [
        (0.58, 0.58, tall - 0.001),
        (0.6, 0.6, tall),
        (0.56, 0.56, size[2] - 0.002),
        (0.5, 0.5, size[2]),
    ]
    return {
        "bottle": _flat(size, rows, 2.6),
        "cap": _flat(size, lid, 2.4),
        "label": _flat(size, middle, 2.6, 2 * _LABEL_M),
    }


def tube(size: Size, rng: np.random.Generator) -> Parts:
    """A tube that stands on its cap."""
    cap = 0.16 * size[2]
    rows = [
        (0.7, 1.0, cap),
        (0.78, 1.0, cap + 0.004),
        (0.85, 0.8, 0.5 * size[2]),
        (0.98, 0.2, 0.93 * size[2]),
        (1.0, 0.09, 0.95 * size[2]),
        (1.0, 0.07, size[2]),
    ]
    band = [(0.8, 0.95, 0.3 * size[2]), (0.85, 0.8, 0.5 * size[2])]
    lid = [(0.66, 0.94, 0.0), (0.7, 1.0, 0.002), (0.7, 1.0, cap - 0.001), (0.6, 0.8, cap + 0.001)]
    return {
        "bottle": _flat(size, rows, 2.0),
        "cap": _flat(size, lid, 2.0),
        "label": _flat(size, band, 2.0, 2 * _LABEL_M),
    }


def cream(size: Size, rng: np.random.Generator) -> Parts:
    """A low jar with a broad lid."""
    r, h = 0.5 * min(size[:2]), size[2]
    split = 0.55 * h
    jar = lathe([(0.0, 0.0), (0.88 * r, 0.0), (0.94 * r, 0.003), (0.94 * r, split), (0.0, split)])
    lid = lathe([(0.0, split), (r, split), (r, h - 0.002), (0.97 * r, h), (0.0, h)])
    return {"bottle": oval(jar, size), "cap": oval(lid, size)}


def spray(size: Size, rng: np.random.Generator) -> Parts:
    """A spray can with its cap."""
    r, h = 0.5 * min(size[:2]), size[2]
    split = 0.74 * h
    can = lathe(
        [
            (0.0, 0.002),
            (0.9 * r, 0.002),
            (0.92 * r, 0.0),
            (r, 0.004),
            (r, split - 0.006),
            (0.8 * r, split),
            (0.0, split),
        ],
        segments=30,
    )
    cap = cylinder(
        0.92 * r, h - split + 0.003, bevel=0.002, segments=28, base=(0.0, 0.0, split - 0.003)
    )
    label = band(r - 0.001, r + _LABEL_M, 0.12 * h, 0.5 * h, 30)
    return {"bottle": oval(can, size), "cap": oval(cap, size), "label": oval(label, size)}


CATEGORY: Final = BuiltCategory(
    description="a bottle, tube, jar or can of toiletries",
    size=(0.07, 0.042, 0.19),
    min_size=(0.03, 0.02, 0.03),
    max_size=(0.14, 0.12, 0.3),
    styles={
        "shampoo": Style(shampoo, lambda size: size[2] > 1.6 * size[0]),
        "tube": Style(tube, lambda size: size[2] > 1.6 * size[0], (0.056, 0.036, 0.15)),
        "cream": Style(cream, lambda size: size[2] < size[0], (0.07, 0.07, 0.046)),
        "spray": Style(spray, lambda size: size[2] > 2.0 * size[0], (0.05, 0.05, 0.16)),
    },
    size_variation=(0.18, 0.12, 0.16),
    support="surface",
    mass_range=(0.02, 0.8),
    words="toiletry shampoo shampoo_bottle lotion cosmetics deodorant toothpaste hair_spray",
    schemes=(scheme("toiletry", toiletry_cap="cap", package_field="label"),),
    construction=(row(ANY, filled(900), "common"),),
    placements=(
        on(
            "basin_edge",
            styles="tube cream spray",
            pose="flat",
            cluster="washing",
            weight=1.4,
            max_groups=5,
            max_variants=4,
        ),
        on("bath_rim", styles="shampoo", count=(1, 2), weight=1.4, max_groups=3, max_variants=4),
        on("shelf low_shelf", "bathroom", count=(1, 3), weight=2.5, max_groups=9, max_variants=5),
        on("cupboard window_sill cistern", "bathroom", weight=0.7, max_groups=4, max_variants=4),
        on("dresser_top bedside", styles="cream tube spray", pose="flat", clutter=2, weight=0.25),
    ),
)
