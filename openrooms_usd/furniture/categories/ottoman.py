"""Upholstered seats without a back: round pouffes, and square ones that open."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import filled, row
from openrooms_usd.furniture.joinery.boards import board, corners, round_leg
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.solids import cushion


def pouffe(size: Size, rng: np.random.Generator) -> Parts:
    """A round or oval drum of cloth with a soft top and a seam."""
    width, depth, height = size
    outline = superellipse(width, depth, 2.2, 48)
    bulge = [
        (0.86, 0.0),
        (0.93, 0.01),
        (0.985, 0.12),
        (1.0, 0.4),
        (0.985, 0.72),
        (0.95, 0.9),
        (0.88, 0.965),
        (0.7, 0.99),
        (0.35, 1.0),
    ]
    body = loft([ring(outline * s, u * height) for s, u in bulge], crease=80.0)
    return {"seat_cushion": body}


def square(size: Size, rng: np.random.Generator) -> Parts:
    """A padded box on short legs."""
    width, depth, height = size
    x, y, foot = 0.5 * width, 0.5 * depth, 0.1
    split = height - 0.13
    legs = [
        round_leg(0.02, 0.013, foot + 0.005).moved((a, b, 0.0))
        for a, b in corners(x - 0.06, y - 0.06)
    ]
    return {
        "frame": board((0.008 - x, 0.008 - y, foot), (x - 0.008, y - 0.008, split), 0.012),
        "seat_cushion": cushion(
            (width, depth, height - split + 0.004),
            radius=0.03,
            crown=(0.004, 0.004, 0.018),
            center=(0.0, 0.0, 0.5 * (height + split) - 0.002),
        ),
        **numbered("leg", legs),
    }


CATEGORY: Final = BuiltCategory(
    description="an upholstered seat without a back",
    size=(0.55, 0.55, 0.42),
    min_size=(0.3, 0.3, 0.25),
    max_size=(1.3, 1.0, 0.6),
    styles={"pouffe": Style(pouffe), "square": Style(square, size=(0.7, 0.55, 0.42))},
    round=True,
    mass_range=(3, 16),
    words="pouffe pouf pouff hassock footstool foot_stool footrest",
    classes=Classes("chair", "chair", "ottoman"),
    schemes=(
        scheme("upholstery", wood="leg", weight=3.0),
        scheme("hide", wood="leg", hide="seat_cushion"),
    ),
    construction=(row("frame", filled(110), "weight"), row("seat_cushion", filled(60), "foam")),
    collision_softness=0.03,
)
