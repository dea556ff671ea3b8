"""Stools: turned legs with rungs, three legs, a high one on a column, a padded cube."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import SEAT_ROWS, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.boards import board, corners, round_leg, splayed, square_leg
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import CHAIRS, METAL, scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cushion, cylinder, lathe
from openrooms_usd.geometry.sweeps import tube

HIGH: Final = 0.56


def _round_seat(size: Size, thick: float) -> Mesh:
    """A turned disc, hollowed a little; oval where the box is not square."""
    width, depth, height = size
    r, edge = 0.5 * width, 0.006
    profile = [
        (0.0, 0.0),
        (0.8 * r, 0.0),
        (r - edge, 0.4 * thick),
        (r, 0.6 * thick),
        (r, thick - edge),
        (r - 0.3 * edge, thick - 0.3 * edge),
        (r - edge, thick),
        (0.85 * r, thick),
        (0.55 * r, thick - 0.004),
        (0.0, thick - 0.006),
    ]
    oval = np.diag([1.0, depth / width, 1.0])
    return lathe(profile, segments=40).transformed(oval).moved((0.0, 0.0, height - thick))


def turned(size: Size, rng: np.random.Generator) -> Parts:
    """A round seat on four splayed legs with rungs between them."""
    width, depth, height = size
    thick = 0.035
    under = height - 0.5 * thick
    radius = 0.017
    leg = round_leg(radius, 0.7 * radius, under)
    feet = corners(0.5 * width - 0.02, 0.5 * depth - 0.02)
    heads = corners(0.26 * width, 0.26 * depth)
    legs = [splayed(leg, foot, head) for foot, head in zip(feet, heads, strict=True)]
    levels = [0.3 * height, 0.42 * height] if height > HIGH else [0.38 * height, 0.46 * height]
    rungs = []
    for i in range(4):
        level = levels[i % 2] + float(rng.uniform(-0.01, 0.01))
        t = level / under
        a, b = (
            np.add(np.multiply(1.0 - t, feet[k]), np.multiply(t, heads[k]))
            for k in (i, (i + 1) % 4)
        )
        rungs.append(tube([(*a, level), (*b, level)], 0.009, segments=10))
    return {
        "seat": _round_seat(size, thick),
        **numbered("leg", legs),
        **numbered("bar_stretcher", rungs),
    }


def tripod(size: Size, rng: np.random.Generator) -> Parts:
    """A thick round seat on three stout legs."""
    width, depth, height = size
    thick = min(0.05, 0.15 * height)
    leg = square_leg(0.038, 0.026, height - thick)
    angle = np.radians(90.0 + 120.0 * np.arange(3))
    spread = np.stack([0.5 * width * np.cos(angle), 0.5 * depth * np.sin(angle)], axis=1)
    share = float(rng.uniform(0.84, 0.92))
    legs = [splayed(leg, share * point, 0.5 * point) for point in spread]
    return {"seat": _round_seat(size, thick), **numbered("leg", legs)}


def column(size: Size, rng: np.random.Generator) -> Parts:
    """A padded round seat on a column with a flat foot and a ring for the feet."""
    width, depth, height = size
    r, pad = 0.5 * width, 0.07
    oval = np.diag([1.0, depth / width, 1.0])
    profile = [
        (0.0, 0.0),
        (r - 0.015, 0.0),
        (r - 0.003, 0.012),
        (r, 0.03),
        (r - 0.004, 0.048),
        (r - 0.02, 0.062),
        (0.6 * r, pad - 0.001),
        (0.0, pad),
    ]
    foot = [
        (0.0, 0.0),
        (0.98 * r, 0.0),
        (0.98 * r, 0.006),
        (0.9 * r, 0.012),
        (0.2 * r, 0.024),
        (0.03, 0.034),
        (0.026, 0.05),
        (0.0, 0.05),
    ]
    level = 0.34 * height
    ring = 0.72 * r
    angle = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    circle = np.stack([ring * np.cos(angle), ring * np.sin(angle), np.full(32, level)], axis=1)
    spokes = int(rng.integers(2, 4))
    turn = np.pi * np.arange(spokes) * 2.0 / spokes - 0.5 * np.pi
    arms = [
        tube([(0.0, 0.0, level), (ring * np.cos(t), ring * np.sin(t), level)], 0.008) for t in turn
    ]
    stem = cylinder(0.022, height - pad - 0.03, segments=20, base=(0.0, 0.0, 0.04))
    return {
        "seat_cushion": lathe(profile, segments=40, crease=50.0)
        .transformed(oval)
        .moved((0.0, 0.0, height - pad)),
        "column": stem,
        "base": lathe(foot, segments=40).transformed(oval),
        "foot_rest": tube(circle, 0.009, segments=8, closed=True),
        **numbered("bar_stretcher", arms),
    }


def padded(size: Size, rng: np.random.Generator) -> Parts:
    """An upholstered block on short feet, its top a cushion of its own."""
    width, depth, height = size
    foot = min(0.05, 0.15 * height)
    top = float(rng.uniform(0.26, 0.34)) * height
    body = cushion(
        (width, depth, height - top - foot + 0.01), radius=0.02, crown=(0.004, 0.004, 0.002)
    )
    pad = cushion((width, depth, top), radius=0.04, crown=(0.006, 0.006, 0.014))
    x, y = 0.5 * width - 0.05, 0.5 * depth - 0.05
    leg = round_leg(0.02, 0.014, foot + 0.015)
    return {
        "cushion": body.moved((0.0, 0.0, foot + 0.5 * (height - top - foot + 0.01))),
        "seat_cushion": pad.moved((0.0, 0.0, height - 0.5 * top)),
        **numbered("leg", [leg.moved((*corner, 0.0)) for corner in corners(x, y)]),
    }


def square(size: Size, rng: np.random.Generator) -> Parts:
    """A square wooden seat of boards on straight legs with a footrest all around."""
    width, depth, height = size
    t, thick = 0.032, 0.02
    x, y = 0.5 * (width - t), 0.5 * (depth - t)
    leg = square_leg(t, t, height - thick + 0.002, 0.003)
    count = int(rng.integers(3, 6))
    pitch = depth / count
    slats = [
        board(
            (-0.5 * width, -0.5 * depth + i * pitch + 0.002, height - thick),
            (0.5 * width, -0.5 * depth + (i + 1) * pitch - 0.002, height),
            0.003,
        )
        for i in range(count)
    ]
    under = height - thick
    rails = []
    for low, tall in ((under - 0.045, 0.045), (0.28 * height, 0.022)):
        for side in (-1.0, 1.0):
            rails.append(board((-x, side * y - 0.009, low), (x, side * y + 0.009, low + tall)))
            rails.append(board((side * x - 0.009, -y, low), (side * x + 0.009, y, low + tall)))
    return {
        **numbered("seat", slats),
        **numbered("leg", [leg.moved((*corner, 0.0)) for corner in corners(x, y)]),
        **numbered("bar_stretcher", rails),
    }


def _low(size: Size) -> bool:
    return size[2] < HIGH


def _rounded(size: Size) -> bool:
    return max(size[:2]) < 1.25 * min(size[:2])


CATEGORY: Final = BuiltCategory(
    description="a seat for one without a back",
    size=(0.38, 0.38, 0.46),
    min_size=(0.22, 0.22, 0.2),
    max_size=(0.9, 0.9, 0.95),
    styles={
        "turned": Style(turned, _rounded),
        "tripod": Style(tripod, lambda size: _low(size) and _rounded(size)),
        "column": Style(column, lambda size: not _low(size) and _rounded(size), (0.4, 0.4, 0.76)),
        "padded": Style(padded, _low, (0.45, 0.45, 0.44)),
        "square": Style(square),
    },
    round=True,
    one_variant_per_room=True,
    mass_range=(2, 9),
    words="bar_stool barstool",
    classes=Classes("chair", "otherprop", "stool", "chair"),
    schemes=(*CHAIRS, scheme(METAL, needs="column", weight=100.0)),
    construction=(
        row("seat_cushion", filled(100), "foam"),
        row("cushion", filled(90), "weight"),
        row("base", walls(2.5, STEEL), "common", "metal", "paint"),
        *SEAT_ROWS,
    ),
)
