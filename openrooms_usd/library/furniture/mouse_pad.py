"""Pads for mice, and mats that cover a good part of a desk."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.lofts import rounded_rectangle
from openrooms_usd.geometry.sweeps import extrude, tube
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style
from openrooms_usd.library.furniture.lying import Lies


def small(size: Size, rng: np.random.Generator) -> Parts:
    """A pad of cloth on rubber."""
    width, depth, height = size
    return {"pad": extrude(rounded_rectangle(width, depth, 0.012, 4), height, bevel=0.001)}


def stitched(size: Size, rng: np.random.Generator) -> Parts:
    """A wide mat with a stitched edge."""
    width, depth, height = size
    outline = rounded_rectangle(width, depth, 0.015, 4)
    inner = rounded_rectangle(width - 0.006, depth - 0.006, 0.012, 4)
    rim = np.column_stack([rounded_rectangle(width - 0.003, depth - 0.003, 0.014, 4),
                           np.full(len(outline), 0.5 * height)])  # fmt: skip
    seam = tube(rim, 0.5 * height, segments=8, closed=True)
    return {"pad": extrude(inner, 0.9 * height), "seam": seam}


CATEGORY: Final = BuiltCategory(
    description="a pad for a mouse",
    size=(0.24, 0.2, 0.005),
    least=(0.1, 0.1, 0.005),
    most=(1.2, 0.6, 0.02),
    styles={
        "small": Style(small, lambda size: size[0] < 0.45),
        "stitched": Style(stitched, lambda size: size[0] > 0.4, (0.8, 0.33, 0.005)),
    },
    spread=USUAL,
    round=False,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.03, 1.2)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="mousepad desk_mat",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "pad_cloth", "seam": "membrane"}),),
    makes=(makes.row(ANY, makes.solid(400), "common"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(Lies(on=("desk",), styles=("small",), weight=0.4, cluster="computer", most=1),),
)
