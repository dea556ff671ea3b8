"""Clothes: a pile as it fell, and a few folded ones."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.cloth import ripples
from openrooms_usd.furniture.joinery.linens import between, folded_pile
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme


def heap(size: Size, rng: np.random.Generator) -> Parts:
    """Clothes on a heap, in three layers."""
    width, depth, height = size
    found = []
    for k in range(3):
        w, d = width * (1.0 - 0.13 * k), depth * (1.0 - 0.13 * k)
        u, v = np.meshgrid(np.linspace(-1.0, 1.0, 11), np.linspace(-1.0, 1.0, 9))
        edge = 1.0 - 0.14 * np.abs(ripples(u, v, 1.6, rng))
        scale = (np.maximum(np.abs(u), np.abs(v)) / np.maximum(np.hypot(u, v), 1e-9)) ** 0.3
        x, y = 0.5 * w * u * scale * edge, 0.5 * d * v * scale * edge
        r = np.clip(np.maximum(np.abs(u), np.abs(v)), 0.0, 1.0)
        dome = (1.0 - r**3.5) * (0.75 + 0.25 * ripples(x, y, 0.16, rng))
        top_z = 0.006 + np.clip(dome, 0.0, None)
        high = height * (0.55 + 0.225 * k)
        top_z = np.maximum(high * top_z / top_z.max(), 0.006)
        under = np.maximum(top_z - 0.3 * height, 0.0) if k else 0.0 * top_z
        shift = np.append(rng.uniform(-0.05, 0.05, 2) * [width, depth] * (k > 0), 0.0)
        top = np.stack([x, y, top_z], axis=-1) + shift
        low = np.stack([0.97 * x, 0.97 * y, under], axis=-1) + shift
        layer = between(top, low)
        flat = layer.points[layer.indices, :2].astype(np.float32)
        found.append(replace(layer, st=flat))
    return numbered("garment", found)


def folded(size: Size, rng: np.random.Generator) -> Parts:
    """Folded clothes on each other."""
    width, depth, height = size
    count = max(2, round(height / 0.032))
    each = height / count
    found = []
    for k in range(count):
        w, d = (
            (width, depth)
            if k == 0
            else (width * float(rng.uniform(0.9, 1.0)), depth * float(rng.uniform(0.9, 1.0)))
        )
        found.append(folded_pile((w, d, 0.98 * each), 2, rng).moved((0.0, 0.0, k * each)))
    return numbered("garment", found)


CATEGORY: Final = BuiltCategory(
    description="clothes that lie",
    size=(0.55, 0.48, 0.17),
    min_size=(0.15, 0.15, 0.04),
    max_size=(1.2, 1.0, 0.5),
    styles={
        "heap": Style(heap, lambda size: size[0] > 0.35),
        "folded": Style(folded, lambda size: size[0] < 0.45, (0.32, 0.28, 0.13)),
    },
    alternative_supports=("surface",),
    mass_range=(0.3, 6),
    words="clothes laundry pile_of_clothes clothing_pile shirt pants",
    classes=Classes(nyu40="clothes", ade20k="apparel"),
    schemes=(scheme("garment"),),
    construction=(row(ANY, filled(90), "weight"),),
    placements=(
        on("wardrobe_shelf cupboard drawer", "bedroom", styles="folded", count=(1, 2)),
        on("chair_seat armchair_seat bed_foot", "bedroom", clutter=2, weight=0.5, max_groups=1),
        on("in_basket", "bathroom bedroom laundry_room", styles="heap", weight=0.7, max_groups=1),
        on(
            "floor_open floor_corner floor_beside_bed",
            "bedroom",
            styles="heap",
            clutter=3,
            weight=0.5,
            max_groups=1,
        ),
        on("appliance_top", "bathroom laundry_room", styles="folded", weight=0.4, max_groups=1),
    ),
)
