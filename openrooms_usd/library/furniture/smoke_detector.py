"""Smoke detectors at the ceiling."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NEVER_WEIGHED,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style


def disc(size: Size, rng: np.random.Generator) -> Parts:
    """A low drum with a slot all round and a key in its middle."""
    radius, height = 0.5 * min(size[:2]), size[2]
    profile = [(0.0, 0.002 / height), (0.55, 0.002 / height), (0.86, 0.22), (0.9, 0.4), (0.8, 0.42),
               (0.8, 0.6), (0.97, 0.62), (1.0, 0.7), (1.0, 1.0), (0.0, 1.0)]  # fmt: skip
    body = np.array(profile) * [radius, height]
    key = [(0.0, 0.0), (0.14 * radius, 0.0005), (0.16 * radius, 0.01), (0.0, 0.01)]
    return {"body": lathe(body, segments=32), "button": lathe(key, segments=16)}


STYLES: Final = {"disc": Style(disc)}


CATEGORY: Final = BuiltCategory(
    description="a smoke detector at the ceiling",
    size=(0.115, 0.115, 0.042),
    least=(0.05, 0.05, 0.02),
    most=(0.3, 0.3, 0.15),
    styles=STYLES,
    spread=STANDARD,
    round=True,
    alike=True,
    support="ceiling",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs=NEVER_WEIGHED,
    worktop=NO_APPLIANCE,
    fixed=True,
    words="smoke_alarm fire_alarm",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "plastic"}),),
    makes=(makes.row(ANY, makes.filled(900), "common"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
