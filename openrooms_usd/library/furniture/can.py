"""Cans: a tin of food with its label, and one to drink from."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style
from openrooms_usd.library.furniture.lying import Lies


def tin(size: Size, rng: np.random.Generator) -> Parts:
    """A tin of food with a label of paper."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    body = lathe([(0.0, 0.003), (0.93 * r, 0.003), (0.94 * r, 0.0), (r, 0.0), (r, 0.004),
                  (0.975 * r, 0.006), (0.975 * r, h - 0.006), (r, h - 0.004), (r, h),
                  (0.94 * r, h), (0.93 * r, h - 0.004), (0.0, h - 0.004)], segments=32)  # fmt: skip
    paper = lathe([(0.974 * r, 0.009), (0.983 * r, 0.009), (0.983 * r, h - 0.009),
                   (0.974 * r, h - 0.009)], segments=32)  # fmt: skip
    low, high = sorted(rng.uniform(0.2, 0.75, 2).tolist())
    stripe = lathe([(0.98 * r, low * h), (0.986 * r, low * h), (0.986 * r, (high + 0.1) * h),
                    (0.98 * r, (high + 0.1) * h)], segments=32)  # fmt: skip
    ring_ = tube([(0.3 * r * np.cos(a), -0.35 * r + 0.26 * r * np.sin(a), h - 0.0035)
                  for a in np.linspace(0.0, 2.0 * np.pi, 11)[:-1]], 0.0012, segments=6,
                 closed=True)  # fmt: skip
    return {"container": joined([body, ring_]), "label": paper, "field": stripe}


def drink(size: Size, rng: np.random.Generator) -> Parts:
    """A can to drink from, printed all round."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    neck = 0.82 * r
    ends = [
        lathe([(0.0, 0.007), (0.6 * r, 0.007), (0.72 * r, 0.0), (0.76 * r, 0.0), (0.9 * r, 0.009),
               (0.0, 0.009)], segments=32),
        lathe([(0.0, h - 0.006), (0.96 * neck, h - 0.006), (0.97 * neck, h - 0.001),
               (0.98 * neck, h), (neck, h), (neck, h - 0.003), (0.0, h - 0.008)], segments=32),
    ]  # fmt: skip
    body = lathe([(0.0, 0.0085), (0.89 * r, 0.0085), (r, 0.018), (r, h - 0.019), (neck, h - 0.004),
                  (0.0, h - 0.0065)], segments=32, crease=50.0)  # fmt: skip
    low = float(rng.uniform(0.25, 0.4)) * h
    band = lathe([(r - 0.0004, low), (r + 0.0002, low), (r + 0.0002, low + 0.32 * h),
                  (r - 0.0004, low + 0.32 * h)], segments=32)  # fmt: skip
    return {"cover": body, "container": joined(ends), "field": band}


CATEGORY: Final = BuiltCategory(
    description="a can of food or drink",
    size=(0.075, 0.075, 0.11),
    least=(0.03, 0.03, 0.03),
    most=(0.25, 0.25, 0.3),
    styles={
        "tin": Style(tin),
        "drink": Style(drink, lambda size: size[2] > 1.5 * size[0], (0.066, 0.066, 0.122)),
    },
    spread=STANDARD,
    round=True,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.1, 0.9)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="cans tin soda_can beer_can soup_can coke_can",
    classes=Classes("can", "otherprop", UNLABELED, UNLABELED),
    synsets=("02946921",),
    schemes=(Scheme({ANY: "package", "container": "can_metal", "field": "package_field"}),),
    makes=(
        makes.row("container cover", makes.filled(800), "weight"),
        makes.row(ANY, makes.solid(700), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(
            on=("cupboard", "shelf"), rooms=("kitchen",), styles=("tin",), pose="row", count=(2, 5)
        ),
        Lies(on=("worktop",), rooms=("kitchen",), clutter=2, weight=0.35, count=(1, 2)),
        Lies(on=("desk", "coffee_table"), styles=("drink",), clutter=2, weight=0.35, most=2),
    ),
)
