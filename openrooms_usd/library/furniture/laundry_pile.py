"""Clothes: a pile as it fell, and a few folded ones."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.cloth import ripples
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, numbered
from openrooms_usd.library.furniture.linens import between, folded_pile
from openrooms_usd.library.furniture.lying import Lies


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
        w, d = (width, depth) if k == 0 else (width * float(rng.uniform(0.9, 1.0)),
                                              depth * float(rng.uniform(0.9, 1.0)))  # fmt: skip
        found.append(folded_pile((w, d, 0.98 * each), 2, rng).moved((0.0, 0.0, k * each)))
    return numbered("garment", found)


CATEGORY: Final = BuiltCategory(
    description="clothes that lie",
    size=(0.55, 0.48, 0.17),
    least=(0.15, 0.15, 0.04),
    most=(1.2, 1.0, 0.5),
    styles={
        "heap": Style(heap, lambda size: size[0] > 0.35),
        "folded": Style(folded, lambda size: size[0] < 0.45, (0.32, 0.28, 0.13)),
    },
    spread=USUAL,
    round=False,
    alike=False,
    support="floor",
    also=("surface",),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.3, 6)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="clothes laundry pile_of_clothes clothing_pile shirt pants",
    classes=Classes(UNLABELED, "clothes", "apparel", UNLABELED),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "garment"}),),
    makes=(makes.row(ANY, makes.filled(90), "weight"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(
            on=("wardrobe_shelf", "cupboard", "drawer"),
            rooms=("bedroom",),
            styles=("folded",),
            weight=1.0,
            count=(1, 2),
        ),
        Lies(
            on=("chair_seat", "armchair_seat", "bed_foot"),
            rooms=("bedroom",),
            clutter=2,
            weight=0.5,
            most=1,
        ),
        Lies(
            on=("in_basket",),
            rooms=("bathroom", "bedroom", "laundry_room"),
            styles=("heap",),
            weight=0.7,
            most=1,
        ),
        Lies(
            on=("floor_open", "floor_corner", "floor_beside_bed"),
            rooms=("bedroom",),
            styles=("heap",),
            clutter=3,
            weight=0.5,
            most=1,
        ),
        Lies(
            on=("appliance_top",),
            rooms=("bathroom", "laundry_room"),
            styles=("folded",),
            weight=0.4,
            most=1,
        ),
    ),
)
