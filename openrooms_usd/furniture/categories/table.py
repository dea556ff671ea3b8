"""Tables: four legs, four legs with a shelf, a round pedestal, trestles."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import TABLE_ROWS
from openrooms_usd.furniture.joinery.boards import (
    FRONT,
    SIDE,
    board,
    corners,
    profiled,
    splayed,
    square_leg,
)
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import MADE_TO_MEASURE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import TABLES
from openrooms_usd.geometry.curves import filleted, rectangle
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import extrude


def _top(width: float, depth: float, height: float, thickness: float, radius: float) -> Mesh:
    outline = filleted(rectangle(width, depth), radius, closed=True)
    return extrude(outline, thickness, bevel=0.005, base=height - thickness)


def _leg_width(size: Size) -> float:
    return float(np.clip(0.045 * max(size[0], size[1]), 0.036, 0.07))


def four_legs(size: Size, rng: np.random.Generator) -> Parts:
    """A table with tapered legs at its corners and aprons between them."""
    width, depth, height = size
    thickness, t = (0.028 if height > 0.55 else 0.024), _leg_width(size)
    under = height - thickness
    inset = 0.5 * t + float(rng.uniform(0.008, 0.03))
    x, y = 0.5 * width - inset, 0.5 * depth - inset
    leg = square_leg(t, t * float(rng.uniform(0.55, 1.0)), under)
    tall = min(0.09, 0.2 * height)
    half = 0.4 * t
    aprons = [
        board((-x + half, side * y - 0.011, under - tall), (x - half, side * y + 0.011, under))
        for side in (-1, 1)
    ] + [
        board((side * x - 0.011, -y + half, under - tall), (side * x + 0.011, y - half, under))
        for side in (-1, 1)
    ]
    return {
        "tabletop": _top(width, depth, height, thickness, 0.012),
        **numbered("leg", [leg.moved((*corner, 0.0)) for corner in corners(x, y)]),
        **numbered("frame", aprons),
    }


def shelf(size: Size, rng: np.random.Generator) -> Parts:
    """A low table: slim splayed legs and a shelf between them."""
    width, depth, height = size
    thickness = 0.022
    under = height - thickness
    leg = square_leg(0.036, 0.024, under)
    x, y = 0.5 * width - 0.02, 0.5 * depth - 0.02
    splay = min(0.06, 0.12 * min(width, depth))
    heads, feet = corners(x - splay, y - splay), corners(x, y)
    legs = [splayed(leg, foot, head) for foot, head in zip(feet, heads, strict=True)]
    level = under * float(rng.uniform(0.32, 0.42))
    inner = splay * level / under + 0.004
    board_top = extrude(
        filleted(rectangle(2.0 * (x - inner), 2.0 * (y - inner)), 0.02, closed=True),
        0.016,
        bevel=0.004,
        base=level,
    )
    rails = [
        board(
            (-x + splay, side * (y - splay) - 0.009, under - 0.045),
            (x - splay, side * (y - splay) + 0.009, under),
        )
        for side in (-1, 1)
    ]
    return {
        "tabletop": _top(width, depth, height, thickness, 0.03),
        **numbered("leg", legs),
        "shelf": board_top,
        **numbered("frame", rails),
    }


def pedestal(size: Size, rng: np.random.Generator) -> Parts:
    """A round or oval top on a turned column with a flared foot."""
    width, depth, height = size
    thickness = 0.026
    angle = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    outline = 0.5 * np.stack([width * np.cos(angle), depth * np.sin(angle)], axis=1)
    top = extrude(outline, thickness, bevel=0.009, base=height - thickness)
    foot = 0.32 * min(width, depth)
    stem = float(np.clip(0.11 * foot, 0.03, 0.055)) * float(rng.uniform(0.9, 1.2))
    under = height - thickness
    t = np.linspace(0.0, 1.0, 12)
    flare = np.stack([stem + (foot - stem) * (1.0 - t) ** 3.2, 0.014 + 0.36 * under * t], axis=1)
    crown = np.stack([stem + 1.6 * stem * t**2.5, under - 0.25 * under * (1.0 - t)], axis=1)
    profile = [(0.0, 0.0), (foot - 0.004, 0.0), (foot, 0.004), *flare, *crown, (0.0, under)]
    return {"tabletop": top, "base": lathe(profile, segments=40)}


def trestle(size: Size, rng: np.random.Generator) -> Parts:
    """A long table on two A-shaped trestles tied by a beam."""
    width, depth, height = size
    thickness = 0.034
    under = height - thickness
    x = 0.5 * width - max(0.12, 0.14 * width)
    feet, heads = 0.5 * depth - 0.05, 0.5 * depth * float(rng.uniform(0.3, 0.55))
    bar = 0.055
    slant = [
        [
            (side * (feet - bar), 0.0),
            (side * feet, 0.0),
            (side * (heads + 0.5 * bar), under),
            (side * (heads - 0.5 * bar), under),
        ]
        for side in (-1, 1)
    ]
    legs = [
        profiled(shape, 0.045, SIDE, 0.003).moved((sx * x, 0.0, 0.0))
        for sx in (-1, 1)
        for shape in slant
    ]
    bearers = [
        board(
            (sx * x - 0.0225, -0.45 * depth, under - 0.05), (sx * x + 0.0225, 0.45 * depth, under)
        )
        for sx in (-1, 1)
    ]
    level = 0.3 * under
    reach = feet + (heads - feet) * level / under
    ties = [
        board((sx * x - 0.016, -reach, level), (sx * x + 0.016, reach, level + 0.05))
        for sx in (-1, 1)
    ]
    beam = profiled(
        [
            (-x - 0.07, level + 0.05),
            (x + 0.07, level + 0.05),
            (x + 0.07, level + 0.13),
            (-x - 0.07, level + 0.13),
        ],
        0.03,
        FRONT,
        0.003,
    )
    return {
        "tabletop": _top(width, depth, height, thickness, 0.006),
        **numbered("leg", legs),
        **numbered("frame", [*bearers, *ties, beam]),
    }


def tulip_side(size: Size, rng: np.random.Generator) -> Parts:
    """A small side table: a disc on a slim column and a heavy disc."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    foot = radius * float(rng.uniform(0.62, 0.75))
    return {
        "tabletop": cylinder(
            radius, 0.018, bevel=0.005, segments=56, base=(0.0, 0.0, height - 0.018)
        ),
        "leg": cylinder(0.016, height - 0.03, segments=24, base=(0.0, 0.0, 0.014)),
        "base": cylinder(foot, 0.016, bevel=0.004, segments=48),
    }


def _small(size: Size) -> bool:
    return max(size[0], size[1]) < 0.62


def _low(size: Size) -> bool:
    return size[2] < 0.58


def _nearly_square(size: Size) -> bool:
    return max(size[:2]) < 1.25 * min(size[:2])


CATEGORY: Final = BuiltCategory(
    description="a top on legs, dining or low",
    size=(1.4, 0.8, 0.74),
    min_size=(0.3, 0.3, 0.3),
    max_size=(5.0, 2.5, 1.2),
    styles={
        "four_legs": Style(four_legs),
        "shelf": Style(shelf, _low),
        "pedestal": Style(
            pedestal, lambda size: _nearly_square(size) and not _small(size) and not _low(size)
        ),
        "trestle": Style(trestle, lambda size: size[0] > 1.3 and size[1] > 0.6 and not _low(size)),
        "disc": Style(tulip_side, lambda size: _small(size) and _nearly_square(size)),
    },
    size_variation=MADE_TO_MEASURE,
    mass_range=(11, 50),
    words="dining_table conference_table kitchen_table round_table tables",
    classes=Classes("table", "table", "table", "dining_table"),
    synsets=("04379243",),
    schemes=TABLES,
    construction=TABLE_ROWS,
    offers_surfaces=("dining_table",),
    view_importance=3.0,
)
