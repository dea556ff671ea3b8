"""Smoke detectors at the ceiling."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import lathe


def disc(size: Size, rng: np.random.Generator) -> Parts:
    """A low drum with a slot all round and a key in its middle."""
    radius, height = 0.5 * min(size[:2]), size[2]
    profile = [
        (0.0, 0.002 / height),
        (0.55, 0.002 / height),
        (0.86, 0.22),
        (0.9, 0.4),
        (0.8, 0.42),
        (0.8, 0.6),
        (0.97, 0.62),
        (1.0, 0.7),
        (1.0, 1.0),
        (0.0, 1.0),
    ]
    body = np.array(profile) * [radius, height]
    key = [(0.0, 0.0), (0.14 * radius, 0.0005), (0.16 * radius, 0.01), (0.0, 0.01)]
    return {"body": lathe(body), "button": lathe(key, segments=16)}


CATEGORY: Final = BuiltCategory(
    description="a smoke detector at the ceiling",
    size=(0.115, 0.115, 0.042),
    min_size=(0.05, 0.05, 0.02),
    max_size=(0.3, 0.3, 0.15),
    styles={"disc": Style(disc)},
    size_variation=STANDARD,
    round=True,
    one_variant_per_room=True,
    support="ceiling",
    fixed=True,
    words="smoke_alarm fire_alarm",
    schemes=(scheme("plastic"),),
    construction=(row(ANY, filled(900), "common"),),
)
