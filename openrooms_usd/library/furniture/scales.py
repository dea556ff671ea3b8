"""Bathroom scales."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.lofts import rounded_rectangle
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import extrude
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, board, corners, numbered
from openrooms_usd.library.furniture.lying import Lies


def _feet(size: Size, high: float) -> Parts:
    places = corners(0.38 * size[0], 0.38 * size[1])
    return numbered("foot", [cylinder(0.02, high, segments=16, base=(x, y, 0.0))
                             for x, y in places])  # fmt: skip


def glass(size: Size, rng: np.random.Generator) -> Parts:
    """A thin plate with a small display and four contacts of steel."""
    width, depth, height = size
    plate = extrude(rounded_rectangle(width, depth, 0.025, 6), height - 0.0125, bevel=0.0015,
                    base=0.012)  # fmt: skip
    top = height - 0.0008
    shown = board((-0.045, 0.3 * depth, top - 0.001), (0.045, 0.3 * depth + 0.032, height), 0.0002)
    pads = [cylinder(0.026, 0.0013, segments=24, base=(x, y, top - 0.0005))
            for x, y in corners(0.34 * width, 0.22 * depth)]  # fmt: skip
    return {"plate": plate, "field": shown, **numbered("contact", pads), **_feet(size, 0.013)}


def dial(size: Size, rng: np.random.Generator) -> Parts:
    """A box of sheet metal with a mat of rubber and a round window."""
    width, depth, height = size
    body = extrude(rounded_rectangle(width, depth, 0.03, 6), height - 0.012, bevel=0.006,
                   base=0.01)  # fmt: skip
    mat = board((-0.42 * width, -0.44 * depth, height - 0.004),
                (0.42 * width, 0.16 * depth, height), 0.001)  # fmt: skip
    window = cylinder(0.055, 0.003, bevel=0.001, segments=30,
                      base=(0.0, 0.31 * depth, height - 0.0035))  # fmt: skip
    return {"body": body, "mat": mat, "field": window, **_feet(size, 0.012)}


CATEGORY: Final = BuiltCategory(
    description="bathroom scales",
    size=(0.3, 0.3, 0.026),
    least=(0.2, 0.2, 0.018),
    most=(0.45, 0.45, 0.09),
    styles={
        "glass": Style(glass, lambda size: size[2] < 0.04),
        "dial": Style(dial, lambda size: size[2] > 0.035, (0.27, 0.29, 0.05)),
    },
    spread=USUAL,
    round=False,
    alike=True,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.8, 4)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="scale bathroom_scale weighing_scale bathroom_scales",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "back_painted_glass", "field": "dark_plastic", "contact": "chrome",
                "foot": "black_plastic"}),
        Scheme({ANY: "white", "mat": "tyre", "field": "white_paper", "foot": "black_plastic"},
               needs="mat", weight=100.0),
    ),
    makes=(
        makes.row("plate", makes.solid(2000), "common", "specular_stone"),
        makes.row(ANY, makes.filled(500), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(
            on=("floor_by_wall", "floor_corner"), rooms=("bathroom",), pose="flat", weight=2.5,
            most=1,
        ),
    ),
)  # fmt: skip
