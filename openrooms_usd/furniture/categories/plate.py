"""Plates: flat ones with a rim, and one that rises in a single curve."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import oval
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import lathe


def plate(size: Size, rng: np.random.Generator, *, curved: bool) -> Parts:
    """A plate on its foot ring: flat with a rim that slopes, or curved and a little deeper."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    if curved:
        low = [
            (0.0, 0.1 * h),
            (0.48 * r, 0.1 * h),
            (0.5 * r, 0.0),
            (0.55 * r, 0.0),
            (0.58 * r, 0.1 * h),
            (0.8 * r, 0.26 * h),
            (0.93 * r, 0.55 * h),
            (0.99 * r, 0.93 * h),
        ]
        high = [
            (0.995 * r, h),
            (0.97 * r, 0.96 * h),
            (0.9 * r, 0.62 * h),
            (0.77 * r, 0.4 * h),
            (0.55 * r, 0.27 * h),
            (0.0, 0.24 * h),
        ]
    else:
        low = [
            (0.0, 0.12 * h),
            (0.5 * r, 0.12 * h),
            (0.52 * r, 0.0),
            (0.56 * r, 0.0),
            (0.58 * r, 0.14 * h),
            (0.68 * r, 0.42 * h),
            (0.98 * r, 0.9 * h),
        ]
        high = [
            (r, 0.96 * h),
            (0.985 * r, h),
            (0.7 * r, 0.6 * h),
            (0.64 * r, 0.48 * h),
            (0.59 * r, 0.33 * h),
            (0.54 * r, 0.29 * h),
            (0.0, 0.28 * h),
        ]
    return {"plate": oval(lathe([*low, *high], segments=36, crease=55.0), size)}


CATEGORY: Final = BuiltCategory(
    description="a plate to eat from",
    size=(0.27, 0.27, 0.026),
    min_size=(0.1, 0.1, 0.012),
    max_size=(0.45, 0.45, 0.25),
    styles={
        "dinner": Style(partial(plate, curved=False), lambda size: size[2] < 0.05),
        "coupe": Style(
            partial(plate, curved=True), lambda size: size[2] < 0.07, (0.21, 0.21, 0.032)
        ),
    },
    round=True,
    one_variant_per_room=True,
    support="surface",
    mass_range=(0.2, 1.4),
    words="dish plates dinner_plate saucer crockery",
    classes=Classes(ade20k="plate"),
    schemes=(scheme("porcelain"),),
    construction=(row(ANY, solid(), "common", "specular_stone"),),
    placements=(
        on(
            "cupboard shelf",
            "kitchen dining_room",
            pose="stacked",
            count=(3, 7),
            weight=1.4,
            max_groups=5,
        ),
        on("dining_table", pose="flat", cluster="setting", weight=0.7),
        on(
            "worktop sink_edge",
            pose="stacked",
            count=(1, 4),
            cluster="washing_up",
            clutter=2,
            weight=0.5,
        ),
        on("coffee_table desk", pose="flat", clutter=3, weight=0.15, max_groups=1),
    ),
)
