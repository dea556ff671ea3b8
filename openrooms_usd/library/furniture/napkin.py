"""Napkins: folded flat, and in a ring."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import METAL, Scheme
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style
from openrooms_usd.library.furniture.linens import folded_pile, rolled
from openrooms_usd.library.furniture.lying import Lies
from openrooms_usd.library.furniture.posing import turned


def folded(size: Size, rng: np.random.Generator) -> Parts:
    """A napkin folded into a rectangle."""
    return {"cloth": folded_pile(size, 2, rng)}


def ringed(size: Size, rng: np.random.Generator) -> Parts:
    """A napkin rolled and drawn through a ring."""
    width, depth, height = size
    r = 0.5 * height - 0.002
    roll = rolled((width, depth - 0.004, 2.0 * r), rng).moved((0.0, 0.0, 0.002))
    band = lathe([(1.0 * r, -0.012), (1.0 * r + 0.002, -0.012), (1.0 * r + 0.002, 0.012),
                  (1.0 * r, 0.012)], segments=28)  # fmt: skip
    laid = turned(band, "y", 90.0).transformed(np.diag([1.0, depth / height, 1.0]))
    return {"cloth": roll, "ring": laid.moved((0.0, 0.0, 0.5 * height))}


CATEGORY: Final = BuiltCategory(
    description="a napkin",
    size=(0.1, 0.2, 0.008),
    least=(0.05, 0.02, 0.003),
    most=(0.4, 0.4, 0.08),
    styles={
        "folded": Style(folded, lambda size: size[2] < 0.3 * size[1]),
        "ringed": Style(ringed, lambda size: size[2] >= 0.3 * size[1], (0.2, 0.045, 0.045)),
    },
    spread=USUAL,
    round=False,
    alike=True,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.005, 0.15)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="napkins serviette",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "table_linen", "ring": METAL}),),
    makes=(
        makes.row("ring", makes.solid(), "common", "metal"),
        makes.row(ANY, makes.filled(180), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(on=("dining_table",), cluster="setting", weight=0.6),
        Lies(
            on=("drawer",),
            rooms=("kitchen", "dining_room"),
            styles=("folded",),
            pose="stacked",
            count=(3, 6),
            weight=0.4,
        ),
    ),
)
