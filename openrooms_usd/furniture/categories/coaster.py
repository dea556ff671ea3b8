"""Coasters below glasses and mugs."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import rounded_rectangle, superellipse
from openrooms_usd.geometry.sweeps import extrude


def disc(size: Size, rng: np.random.Generator) -> Parts:
    """A round coaster with a rounded edge."""
    width, depth, height = size
    return {"coaster": extrude(superellipse(width, depth, 2.0, 28), height, bevel=0.3 * height)}


def tile(size: Size, rng: np.random.Generator) -> Parts:
    """A square coaster."""
    width, depth, height = size
    return {"coaster": extrude(rounded_rectangle(width, depth, 0.008), height, bevel=0.0012)}


CATEGORY: Final = BuiltCategory(
    description="a coaster below a glass",
    size=(0.1, 0.1, 0.006),
    min_size=(0.06, 0.06, 0.005),
    max_size=(0.2, 0.2, 0.02),
    styles={"disc": Style(disc), "tile": Style(tile)},
    size_variation=STANDARD,
    round=True,
    one_variant_per_room=True,
    support="surface",
    mass_range=(0.01, 0.25),
    words="coasters",
    schemes=(scheme("cork"), scheme("wood"), scheme("stone", weight=0.7)),
    construction=(
        row(ANY, solid(2500), "common", "specular_stone"),
        row(ANY, solid(500), "common"),
    ),
    placements=(on("coffee_table desk side_table", pose="stacked", count=(1, 4), weight=0.3),),
)
