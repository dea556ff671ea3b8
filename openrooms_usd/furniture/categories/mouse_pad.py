"""Pads for mice, and mats that cover a good part of a desk."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import rounded_rectangle
from openrooms_usd.geometry.sweeps import extrude, tube


def small(size: Size, rng: np.random.Generator) -> Parts:
    """A pad of cloth on rubber."""
    width, depth, height = size
    return {"pad": extrude(rounded_rectangle(width, depth, 0.012), height, bevel=0.001)}


def stitched(size: Size, rng: np.random.Generator) -> Parts:
    """A wide mat with a stitched edge."""
    width, depth, height = size
    outline = rounded_rectangle(width, depth, 0.015)
    inner = rounded_rectangle(width - 0.006, depth - 0.006, 0.012)
    rim = np.column_stack(
        [
            rounded_rectangle(width - 0.003, depth - 0.003, 0.014),
            np.full(len(outline), 0.5 * height),
        ]
    )
    seam = tube(rim, 0.5 * height, segments=8, closed=True)
    return {"pad": extrude(inner, 0.9 * height), "seam": seam}


CATEGORY: Final = BuiltCategory(
    description="a pad for a mouse",
    size=(0.24, 0.2, 0.005),
    min_size=(0.1, 0.1, 0.005),
    max_size=(1.2, 0.6, 0.02),
    styles={
        "small": Style(small, lambda size: size[0] < 0.45),
        "stitched": Style(stitched, lambda size: size[0] > 0.4, (0.8, 0.33, 0.005)),
    },
    lies_under=True,
    support="surface",
    mass_range=(0.03, 1.2),
    words="mousepad desk_mat",
    schemes=(scheme("pad_cloth", membrane="seam"),),
    construction=(row(ANY, solid(400), "common"),),
    placements=(on("desk", styles="small", weight=0.4, cluster="computer", max_groups=1),),
)
