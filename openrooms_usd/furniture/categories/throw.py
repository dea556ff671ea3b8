"""Throws: blankets folded on a sofa or bed, and laid over an edge."""

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
    """A blanket folded into a packet."""
    return {"blanket": folded_pile(size, 4, rng)}


def draped(size: Size, rng: np.random.Generator) -> Parts:
    """A blanket over the arm or the back of something."""
    return {"blanket": over_bar(size, rng)}


def spread(size: Size, rng: np.random.Generator) -> Parts:
    """A blanket in soft folds."""
    width, depth, height = size
    u, v = np.meshgrid(np.linspace(-1.0, 1.0, 21), np.linspace(-1.0, 1.0, 15))
    x, y = 0.5 * width * u, 0.5 * depth * v
    bend = 1.0 - 0.1 * np.abs(ripples(v, u, 1.5, rng))
    lift = np.clip(0.5 + 0.5 * ripples(x, 0.5 * y, 0.22, rng), 0.0, None)
    z = lift * np.clip(4.0 * (1.0 - np.maximum(np.abs(u), np.abs(v))), 0.15, 1.0)
    z = 0.008 + (height - 0.008) * (z - z.min()) / (z.max() - z.min())
    top = np.stack([x * bend, y * bend, z], axis=-1)
    bottom = np.stack([0.995 * x * bend, 0.995 * y * bend, 0.0 * z], axis=-1)
    return {"blanket": between(top, bottom)}


CATEGORY: Final = BuiltCategory(
    description="a blanket for sofas and beds",
    size=(0.5, 0.38, 0.08),
    min_size=(0.2, 0.03, 0.02),
    max_size=(2.2, 1.8, 1.0),
    styles={
        "folded": Style(folded, lambda size: size[2] < 0.2 and size[0] < 0.8),
        "spread": Style(spread, lambda size: size[2] < 0.25 * size[1], (0.85, 0.6, 0.06)),
        "draped": Style(draped, lambda size: size[1] < 0.7 * size[2], (0.6, 0.12, 0.5)),
    },
    support="surface",
    mass_range=(0.4, 3),
    words="blanket throws throw_blanket plaid quilt afghan comforter",
    lies_under=True,
    classes=Classes(ade20k="blanket"),
    schemes=(scheme("throw"),),
    construction=(row(ANY, filled(130), "common"),),
    placements=(
        on("sofa_arm", styles="draped", pose="draped", weight=0.7, max_groups=1),
        on("sofa_seat armchair_seat", styles="folded", pose="flat", weight=0.5, max_groups=1),
        on("bed_foot", styles="spread folded", weight=0.6, max_groups=1),
        on(
            "in_basket low_shelf wardrobe_shelf",
            "living_room bedroom apartment hotel lounge closet",
            styles="folded",
            weight=0.4,
        ),
        on(
            "chair_back",
            "living_room bedroom",
            styles="draped",
            pose="draped",
            clutter=2,
            weight=0.25,
            max_groups=1,
        ),
    ),
)
