"""Roses of plaster around the lamp in the middle of a ceiling."""

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

# The hole for the canopy of the lamp, metres.
_HOLE_M: Final = 0.075


def _turned(size: Size, profile: list[tuple[float, float]]) -> Parts:
    """A ring from shares of the way from the hole to the rim, and shares of the height."""
    radius, height = 0.5 * min(size[:2]), size[2]
    ring = [(_HOLE_M + r * (radius - _HOLE_M), height * (1.0 - h)) for r, h in profile]
    return {"body": lathe(ring, segments=48)}


def stepped(size: Size, rng: np.random.Generator) -> Parts:
    """Rings that grow thicker to the middle."""
    profile = [(0.0, 0.0), (0.0, 1.0), (0.25, 1.0), (0.3, 0.7), (0.55, 0.66), (0.6, 0.4),
               (0.85, 0.36), (0.9, 0.5), (0.96, 0.5), (1.0, 0.3), (1.0, 0.0)]  # fmt: skip
    return _turned(size, profile)


def domed(size: Size, rng: np.random.Generator) -> Parts:
    """A smooth swelling between two beads."""
    t = np.linspace(0.0, 1.0, 7)
    dome = [(float(0.2 + 0.55 * x), float(0.85 - 0.5 * x**2)) for x in t]
    return _turned(size, [(0.0, 0.0), (0.0, 0.8), (0.08, 1.0), (0.16, 0.8), *dome, (0.82, 0.25),
                          (0.9, 0.45), (0.98, 0.25), (1.0, 0.0)])  # fmt: skip


STYLES: Final = {"stepped": Style(stepped), "domed": Style(domed)}


CATEGORY: Final = BuiltCategory(
    description="a rose of plaster around a lamp at the ceiling",
    size=(0.5, 0.5, 0.03),
    least=(0.25, 0.25, 0.015),
    most=(1.5, 1.5, 0.15),
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
    words="ceiling_medallion ceiling_rosette",
    classes=Classes("ceiling", "otherstructure", "ceiling", UNLABELED),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "white"}),),
    makes=(makes.row(ANY, makes.filled(900), "common"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
