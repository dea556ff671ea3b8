"""A plain box: what is kept of things that the library does not know."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes


def plain(size: Size, rng: np.random.Generator) -> Parts:
    """A box with slightly rounded edges."""
    width, depth, height = size
    edge = min(0.004, 0.2 * min(size))
    low, high = (-0.5 * width, -0.5 * depth, 0.0), (0.5 * width, 0.5 * depth, height)
    return {"body": board(low, high, edge)}


_STORES: Final = "storage basement garage copy_room mail_room laundry_room"

CATEGORY: Final = BuiltCategory(
    description="a plain box",
    size=(0.4, 0.3, 0.3),
    min_size=(0.02, 0.02, 0.02),
    max_size=(20.0, 20.0, 20.0),
    styles={"plain": Style(plain)},
    size_variation=WIDE,
    alternative_supports=("surface",),
    mass_range=(1, 10),
    words="cardboard_box boxes crate carton storage_box storage_container",
    classes=Classes(nyu40="box", ade20k="box"),
    construction=(row(ANY, filled(100), "weight"),),
    placements=(
        on("low_shelf shelf", _STORES, weight=1.5, max_groups=12, max_variants=3),
        on("wardrobe_shelf cupboard drawer", weight=0.8, max_groups=4),
        on("low_shelf shelf cabinet_top desk", weight=0.3, max_groups=3),
        on("floor_corner floor_by_wall", clutter=3, weight=0.5),
    ),
)
