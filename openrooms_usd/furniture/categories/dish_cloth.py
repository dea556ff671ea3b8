"""Cloths for dishes: folded, over an edge, and crumpled."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.cloth import ripples
from openrooms_usd.furniture.joinery.linens import between, folded_pile, over_bar
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme


def folded(size: Size, rng: np.random.Generator) -> Parts:
    """A cloth folded once and again."""
    return {"cloth": folded_pile(size, 3, rng)}


def draped(size: Size, rng: np.random.Generator) -> Parts:
    """A cloth over the handle of an oven or the edge of a sink."""
    return {"cloth": over_bar(size, rng)}


def crumpled(size: Size, rng: np.random.Generator) -> Parts:
    """A cloth that was put down as it was."""
    width, depth, height = size
    u, v = np.meshgrid(np.linspace(-1.0, 1.0, 15), np.linspace(-1.0, 1.0, 13))
    x, y = 0.5 * width * u, 0.5 * depth * v
    edge = 1.0 - 0.12 * np.abs(ripples(v, u, 1.2, rng))
    lift = 0.5 + 0.5 * ripples(x, y, 0.13, rng)
    rim = np.clip(3.0 * (1.0 - np.maximum(np.abs(u), np.abs(v))), 0.12, 1.0)
    z = np.clip(lift, 0.0, None) * rim
    z = 0.0025 + (height - 0.0025) * (z - z.min()) / (z.max() - z.min())
    top = np.stack([x * edge, y * edge, z], axis=-1)
    bottom = np.stack([0.99 * x * edge, 0.99 * y * edge, 0.0 * z], axis=-1)
    return {"cloth": between(top, bottom)}


CATEGORY: Final = BuiltCategory(
    description="a cloth to dry dishes",
    size=(0.24, 0.17, 0.014),
    min_size=(0.08, 0.03, 0.006),
    max_size=(0.8, 0.6, 0.8),
    styles={
        "folded": Style(folded, lambda size: size[2] < 0.02),
        "crumpled": Style(crumpled, lambda size: 0.015 < size[2] < size[1], (0.27, 0.22, 0.04)),
        "draped": Style(draped, lambda size: size[2] > 1.5 * size[1], (0.34, 0.045, 0.34)),
    },
    support="surface",
    mass_range=(0.04, 0.4),
    words="dishcloth tea_towel kitchen_towel dish_towel cloth rag washcloth",
    lies_under=True,
    classes=Classes(nyu40="towel", ade20k="towel"),
    schemes=(scheme("dish_linen"),),
    construction=(row(ANY, filled(160), "common"),),
    placements=(
        on("towel_rail", "kitchen", styles="draped", pose="draped", max_groups=1),
        on(
            "worktop sink_edge",
            "kitchen",
            styles="folded crumpled",
            weight=0.8,
            cluster="washing_up",
            pose="flat",
        ),
        on("drawer", "kitchen", styles="folded", pose="stacked", count=(2, 4), weight=0.6),
        on(
            "chair_back",
            "kitchen",
            styles="draped",
            pose="draped",
            clutter=3,
            weight=0.3,
            max_groups=1,
        ),
    ),
)
