"""Cans: a tin of food with its label, and one to drink from."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import band
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube


def tin(size: Size, rng: np.random.Generator) -> Parts:
    """A tin of food with a label of paper."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    body = lathe(
        [
            (0.0, 0.003),
            (0.93 * r, 0.003),
            (0.94 * r, 0.0),
            (r, 0.0),
            (r, 0.004),
            (0.975 * r, 0.006),
            (0.975 * r, h - 0.006),
            (r, h - 0.004),
            (r, h),
            (0.94 * r, h),
            (0.93 * r, h - 0.004),
            (0.0, h - 0.004),
        ]
    )
    paper = band(0.974 * r, 0.983 * r, 0.009, h - 0.009)
    low, high = sorted(rng.uniform(0.2, 0.75, 2).tolist())
    stripe = band(0.98 * r, 0.986 * r, low * h, (high + 0.1) * h)
    ring_ = tube(
        [
            (0.3 * r * np.cos(a), -0.35 * r + 0.26 * r * np.sin(a), h - 0.0035)
            for a in np.linspace(0.0, 2.0 * np.pi, 11)[:-1]
        ],
        0.0012,
        segments=6,
        closed=True,
    )
    return {"container": joined([body, ring_]), "label": paper, "field": stripe}


def drink(size: Size, rng: np.random.Generator) -> Parts:
    """A can to drink from, printed all round."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    neck = 0.82 * r
    ends = [
        lathe(
            [
                (0.0, 0.007),
                (0.6 * r, 0.007),
                (0.72 * r, 0.0),
                (0.76 * r, 0.0),
                (0.9 * r, 0.009),
                (0.0, 0.009),
            ]
        ),
        lathe(
            [
                (0.0, h - 0.006),
                (0.96 * neck, h - 0.006),
                (0.97 * neck, h - 0.001),
                (0.98 * neck, h),
                (neck, h),
                (neck, h - 0.003),
                (0.0, h - 0.008),
            ]
        ),
    ]
    body = lathe(
        [
            (0.0, 0.0085),
            (0.89 * r, 0.0085),
            (r, 0.018),
            (r, h - 0.019),
            (neck, h - 0.004),
            (0.0, h - 0.0065),
        ],
        crease=50.0,
    )
    low = float(rng.uniform(0.25, 0.4)) * h
    printed = band(r - 0.0004, r + 0.0002, low, low + 0.32 * h)
    return {"cover": body, "container": joined(ends), "field": printed}


CATEGORY: Final = BuiltCategory(
    description="a can of food or drink",
    size=(0.075, 0.075, 0.11),
    min_size=(0.03, 0.03, 0.03),
    max_size=(0.25, 0.25, 0.3),
    styles={
        "tin": Style(tin),
        "drink": Style(drink, lambda size: size[2] > 1.5 * size[0], (0.066, 0.066, 0.122)),
    },
    size_variation=STANDARD,
    round=True,
    support="surface",
    mass_range=(0.1, 0.9),
    words="cans tin soda_can beer_can soup_can coke_can",
    classes=Classes(openrooms45="can"),
    synsets=("02946921",),
    schemes=(scheme("package", can_metal="container", package_field="field"),),
    construction=(row("container cover", filled(800), "weight"), row(ANY, solid(700), "common")),
    placements=(
        on("cupboard shelf", "kitchen", styles="tin", pose="row", count=(2, 5)),
        on("worktop", "kitchen", clutter=2, weight=0.35, count=(1, 2)),
        on("desk coffee_table", styles="drink", clutter=2, weight=0.35),
    ),
)
