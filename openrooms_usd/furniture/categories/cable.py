"""Cables that lie about: a charger with its cable, a strip of sockets, a loose coil."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import at_rest
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.sweeps import tube


def _lying(points: ArrayLike, thick: float) -> Mesh:
    """A cable on the ground along points (x, y), rounded."""
    flat = np.asarray(points, dtype=np.float64)
    path = np.insert(filleted(flat, 0.025), 2, thick, axis=1)
    return tube(path, thick, segments=6)


def charger(size: Size, rng: np.random.Generator) -> Parts:
    """A charger with a thin cable in bends, and the plug at its end."""
    width, depth, height = size
    x, y = 0.5 * width, 0.5 * depth
    brick = board((-x, -y, 0.0), (-x + 0.042, -y + 0.042, height), 0.004)
    pins = [
        board((-x + at, -y + 0.041, 0.011), (-x + at + 0.004, -y + 0.058, 0.015), 0.001)
        for at in (0.013, 0.025)
    ]
    a = float(rng.uniform(-0.1, 0.1))
    t = 0.0017
    way = [
        (-x + 0.041, -y + 0.02),
        (-0.2 * x, -y + t),
        (0.35 * x, (-0.5 + a) * y),
        (-0.3 * x, 0.25 * y),
        (-0.1 * x, 1.03 * y),
        (1.1 * x, (0.55 + a) * y),
        (0.62 * x, -0.1 * y),
    ]
    ex, ey = way[-1]
    plug = board((ex - 0.0045, ey - 0.02, 0.0), (ex + 0.0045, ey + 0.001, 0.0065), 0.0012)
    return {"body": joined([brick, plug]), "pin": joined(pins), "cable": _lying(way, t)}


def coil(size: Size, rng: np.random.Generator) -> Parts:
    """A cable wound up, a tie around it."""
    width, depth, height = size
    turns, thick = 4, 0.24 * height
    t = np.linspace(0.0, 2.0 * np.pi * turns, 18 * turns)
    wobble = 1.0 - 0.1 * np.abs(np.sin(0.37 * t + float(rng.uniform(0.0, 6.0))))
    z = thick + (height - 2.0 * thick) * (0.5 - 0.5 * np.cos(0.5 * t))
    path = np.stack(
        [(0.5 * width - thick) * wobble * np.cos(t), (0.5 * depth - thick) * wobble * np.sin(t), z],
        axis=1,
    )
    ends = [(0.36 * width, y, 0.5 * height) for y in (-0.006, 0.006)]
    tie = tube(ends, 0.5 * height)
    return at_rest({"cable": tube(path, thick, segments=6), "tie": tie}, size)


CATEGORY: Final = BuiltCategory(
    description="a charger or a cable",
    size=(0.32, 0.24, 0.028),
    min_size=(0.08, 0.08, 0.008),
    max_size=(1.0, 1.0, 0.08),
    styles={"charger": Style(charger), "coil": Style(coil, size=(0.14, 0.12, 0.02))},
    support="surface",
    mass_range=(0.02, 0.4),
    words="charger wire cord cables phone_charger power_cord extension_cord",
    schemes=(
        scheme("plastic", steel="pin", membrane="tie", weight=2.0),
        scheme("black_plastic", steel="pin", grey="tie"),
    ),
    construction=(row(ANY, solid(1300), "common"),),
    placements=(
        on(
            "desk bedside", styles="charger", pose="flat", weight=0.5, cluster="charging", clutter=2
        ),
        on(
            "drawer shelf media_top",
            styles="coil",
            pose="flat",
            weight=0.3,
            clutter=2,
            max_groups=1,
        ),
        on("floor_by_wall", styles="charger", pose="flat", weight=0.25, clutter=3, max_groups=1),
    ),
)
