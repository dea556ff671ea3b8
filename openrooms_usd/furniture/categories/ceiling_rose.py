"""Roses of plaster around the lamp in the middle of a ceiling."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import lathe

# The hole for the canopy of the lamp, metres.
_HOLE_M: Final = 0.075


def _turned(size: Size, profile: list[tuple[float, float]]) -> Parts:
    """A ring from shares of the way from the hole to the rim, and shares of the height."""
    radius, height = 0.5 * min(size[:2]), size[2]
    ring = [(_HOLE_M + r * (radius - _HOLE_M), height * (1.0 - h)) for r, h in profile]
    return {"body": lathe(ring, segments=48)}


def stepped(size: Size, rng: np.random.Generator) -> Parts:
    """Rings that grow thicker to the middle."""
    profile = [
        (0.0, 0.0),
        (0.0, 1.0),
        (0.25, 1.0),
        (0.3, 0.7),
        (0.55, 0.66),
        (0.6, 0.4),
        (0.85, 0.36),
        (0.9, 0.5),
        (0.96, 0.5),
        (1.0, 0.3),
        (1.0, 0.0),
    ]
    return _turned(size, profile)


def domed(size: Size, rng: np.random.Generator) -> Parts:
    """A smooth swelling between two beads."""
    t = np.linspace(0.0, 1.0, 7)
    dome = [(float(0.2 + 0.55 * x), float(0.85 - 0.5 * x**2)) for x in t]
    return _turned(
        size,
        [
            (0.0, 0.0),
            (0.0, 0.8),
            (0.08, 1.0),
            (0.16, 0.8),
            *dome,
            (0.82, 0.25),
            (0.9, 0.45),
            (0.98, 0.25),
            (1.0, 0.0),
        ],
    )


CATEGORY: Final = BuiltCategory(
    description="a rose of plaster around a lamp at the ceiling",
    size=(0.5, 0.5, 0.03),
    max_size=(1.5, 1.5, 0.15),
    styles={"stepped": Style(stepped), "domed": Style(domed)},
    size_variation=STANDARD,
    round=True,
    one_variant_per_room=True,
    support="ceiling",
    fixed=True,
    words="ceiling_medallion ceiling_rosette",
    classes=Classes("ceiling", "otherstructure", "ceiling"),
    schemes=(scheme("white"),),
    construction=(row(ANY, filled(900), "common"),),
)
