"""Toilet brushes in their holders."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, walls
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import oval
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import METAL, scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import lathe, sphere


def _stick(height: float, low: float) -> Mesh:
    """A handle with a knob at its end."""
    return lathe(
        [
            (0.0, low),
            (0.007, low),
            (0.007, height - 0.05),
            (0.011, height - 0.035),
            (0.012, height - 0.01),
            (0.008, height),
            (0.0, height),
        ],
        segments=18,
    )


def cup(size: Size, rng: np.random.Generator) -> Parts:
    """A slim cup whose lid is on the brush's handle."""
    r, cup_ = 0.5 * min(size[:2]), 0.42 * size[2]
    wall = 0.004
    body = lathe(
        [(0.0, 0.0), (r, 0.0), (r, cup_), (r - wall, cup_), (r - wall, 0.006), (0.0, 0.006)],
        crease=50.0,
    )
    lid = lathe(
        [
            (0.0, cup_ + 0.001),
            (r, cup_ + 0.001),
            (r, cup_ + 0.006),
            (0.3 * r, cup_ + 0.012),
            (0.0, cup_ + 0.012),
        ]
    )
    return {
        "container": oval(body, size),
        "lid": oval(lid, size),
        "handle": _stick(size[2], cup_ + 0.008),
    }


def open_cup(size: Size, rng: np.random.Generator) -> Parts:
    """A round pot in which the brush stands and shows its bristles."""
    r, pot, wall = 0.5 * min(size[:2]), 0.3 * size[2], 0.005
    outer = [(0.7 * r, 0.0), (0.95 * r, 0.25 * pot), (r, 0.6 * pot), (0.86 * r, pot)]
    inner = [(a - wall, max(z, 0.008)) for a, z in outer[::-1]]
    body = lathe([(0.0, 0.0), *outer, *inner, (0.0, 0.008)], crease=50.0)
    bristles = sphere(0.62 * r, segments=20, squash=1.25, center=(0.0, 0.0, 0.95 * pot))
    return {
        "container": oval(body, size),
        "bristle": bristles,
        "handle": _stick(size[2], 1.1 * pot),
    }


CATEGORY: Final = BuiltCategory(
    description="a toilet brush in its holder",
    size=(0.1, 0.1, 0.39),
    min_size=(0.06, 0.06, 0.2),
    max_size=(0.2, 0.2, 0.6),
    styles={"cup": Style(cup), "open": Style(open_cup, size=(0.13, 0.13, 0.4))},
    round=True,
    one_variant_per_room=True,
    mass_range=(0.2, 1.5),
    words="toilet_brushes toilet_brush_holder",
    schemes=(
        scheme(METAL, pale_plastic="bristle", weight=2.0),
        scheme("porcelain", metal="handle lid", pale_plastic="bristle"),
        scheme("pale_plastic", pale_plastic="bristle handle"),
    ),
    construction=(
        row("container", walls(2.0), "common", "specular_stone"),
        row(ANY, filled(300), "common"),
    ),
)
