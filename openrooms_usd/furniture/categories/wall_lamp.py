"""Lamps on a wall: their plates are flat against it, at +Y."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import LAMP_ROWS
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.lamp_parts import bulb, carrier, holder, shade
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import facing
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import LAMPS, SOCKETED
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, sphere
from openrooms_usd.geometry.sweeps import sheet, tube
from openrooms_usd.geometry.vectors import points_at


def _plate(radius: float, back: float, z: float) -> Mesh:
    """A round plate against the wall."""
    return facing(cylinder(radius, 0.016, bevel=0.004, segments=36), (0.0, back, z))


def sconce(size: Size, rng: np.random.Generator) -> Parts:
    """A half round screen, open above and below, that washes the wall."""
    width, depth, height = size
    back, half = 0.5 * depth, 0.5 * width
    angle = np.linspace(-np.pi, 0.0, 25)
    flare = float(rng.uniform(0.0, 0.2))
    rows = np.linspace(0.0, 1.0, 7)
    scale = 1.0 - flare * (1.0 - rows)
    grid = points_at(
        scale[:, None] * half * np.cos(angle),
        back - 0.008 + scale[:, None] * (depth - 0.008) * np.sin(angle),
        (height * rows)[:, None],
    )
    tall = 0.22 * height
    middle = 0.5 * height
    plate = board(
        (-0.16 * width, back - 0.012, 0.2 * height), (0.16 * width, back, 0.7 * height), 0.003
    )
    arm = board((-0.012, back - 0.5 * depth, middle - 0.006), (0.012, back - 0.01, middle + 0.006))
    at = (0.0, back - 0.5 * depth, middle)
    ball = min(0.22 * width, 0.24 * depth, tall)
    return {
        "base": plate,
        "frame": joined([arm, holder(0.0).moved(at)]),
        "lamp_shade": sheet(grid, 0.002),
        "light_bulb": sphere(ball, segments=24, center=(0.0, at[1], middle + 0.03 + ball)),
    }


def globe(size: Size, rng: np.random.Generator) -> Parts:
    """An opal globe on a bent arm."""
    width, depth, height = size
    back = 0.5 * depth
    ball = min(0.5 * width, 0.42 * depth, 0.36 * height)
    y, top = -0.5 * depth + ball, height - ball
    low = float(rng.uniform(0.15, 0.22)) * height
    plate = min(0.5 * width, low, 0.06)
    path = [(0.0, back - 0.01, low), (0.0, y, low), (0.0, y, top - ball)]
    cup = cylinder(0.42 * ball, 0.03, bevel=0.005, segments=28, base=(0.0, y, top - ball - 0.012))
    return {
        "base": _plate(max(plate, low), back, low),
        "lamp_pole": tube(path, 0.0075, bend=0.3 * (back - y)),
        "frame": cup,
        "light_bulb": sphere(ball, center=(0.0, y, top)),
    }


def swing(size: Size, rng: np.random.Generator) -> Parts:
    """A shade on an arm that folds away from a long plate."""
    width, depth, height = size
    back, radius = 0.5 * depth, min(0.5 * width, 0.42 * depth)
    tall = 0.5 * height
    y, low = -0.5 * depth + radius, height - tall
    level = 0.4 * low
    aside = float(rng.choice([-1.0, 1.0])) * 0.25 * width
    path = [
        (0.0, back - 0.012, level),
        (aside, 0.5 * (back + y), level),
        (0.0, y, level),
        (0.0, y, low + 0.35 * tall),
    ]
    arms = tube(path, 0.006, bend=0.012, segments=10)
    plate = board((-0.028, back - 0.014, 0.0), (0.028, back, 0.55 * height), 0.005)
    socket = low + 0.34 * tall
    top = float(rng.uniform(0.78, 0.94)) * radius
    ring = 0.5 * (radius + top)
    bar = carrier(ring - 0.003, low + 0.5 * tall).moved((0.0, y, 0.0))
    return {
        "base": plate,
        "lamp_pole": arms,
        "frame": joined([holder(socket).moved((0.0, y, 0.0)), bar]),
        "lamp_shade": shade(radius, top, low, height).moved((0.0, y, 0.0)),
        "light_bulb": bulb(min(0.026, 0.22 * tall)).moved((0.0, y, socket + 0.035)),
    }


CATEGORY: Final = BuiltCategory(
    description="a lamp on a wall",
    size=(0.2, 0.14, 0.26),
    min_size=(0.1, 0.08, 0.14),
    max_size=(0.6, 0.7, 0.8),
    styles={
        "sconce": Style(sconce),
        "globe": Style(globe, size=(0.18, 0.24, 0.3)),
        "swing": Style(swing, lambda size: size[1] > 0.2, (0.24, 0.36, 0.32)),
    },
    one_variant_per_room=True,
    support="wall",
    mount_height=1.6,
    fixed=True,
    lumen=600.0,
    mass_range=(0.3, 3),
    words="sconce wall_light",
    classes=Classes("lamp", "lamp", "sconce"),
    schemes=(*LAMPS, *SOCKETED),
    construction=LAMP_ROWS,
    view_importance=0.0,
)
