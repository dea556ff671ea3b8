"""Pens and pencils."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import lathe


def _barrel(profile: Sequence[tuple[float, float]], long: float, sides: int) -> Mesh:
    """A body turned about its axis, which lies along Y with its point to the front."""
    r, t = np.array(profile).T
    solid = lathe(np.stack([r, long * t], axis=1), segments=sides, crease=30.0)
    return turned(solid, "x", 90.0).moved((0.0, 0.5 * long, 0.0))


def ballpoint(size: Size, rng: np.random.Generator) -> Parts:
    """A pen with a clip and a button."""
    width, long, height = size
    r = 0.5 * width
    body = _barrel([(0.0, 0.09), (0.8 * r, 0.09), (r, 0.3), (r, 0.96), (0.0, 0.96)], long, 14)
    tip = _barrel(
        [(0.0, 0.0), (0.12 * r, 0.0), (0.2 * r, 0.02), (0.75 * r, 0.09), (0.0, 0.1)], long, 12
    )
    knob = _barrel([(0.0, 0.95), (0.5 * r, 0.95), (0.5 * r, 1.0), (0.0, 1.0)], long, 12)
    clip = board((-0.25 * r, -0.46 * long, 0.9 * r), (0.25 * r, -0.2 * long, height - r), 0.0004)
    steel = joined([tip, knob, clip])
    up = (0.0, 0.0, r)
    flip = np.diag([1.0, -1.0, 1.0, 1.0])
    return {"pen": body.transformed(flip).moved(up), "tip": steel.transformed(flip).moved(up)}


def pencil(size: Size, rng: np.random.Generator) -> Parts:
    """A pencil of six sides with an eraser."""
    width, long, _ = size
    r = 0.5 * width
    # What is round stays within the six sides, so that it lies on one of them.
    body = _barrel([(0.0, 0.1), (r, 0.1), (r, 0.93), (0.0, 0.93)], long, 6)
    cone = _barrel([(0.0, 0.012), (0.15 * r, 0.012), (0.86 * r, 0.103), (0.0, 0.103)], long, 12)
    lead = _barrel([(0.0, 0.0), (0.05 * r, 0.0), (0.16 * r, 0.014), (0.0, 0.014)], long, 8)
    rubber = _barrel(
        [(0.0, 0.925), (0.86 * r, 0.925), (0.86 * r, 0.99), (0.65 * r, 1.0), (0.0, 1.0)], long, 12
    )
    flip = np.diag([1.0, -1.0, 1.0, 1.0])
    parts = {"pen": body, "wood": cone, "tip": lead, "eraser": rubber}
    return {
        name: mesh.transformed(flip).moved((0.0, 0.0, 0.866 * r)) for name, mesh in parts.items()
    }


CATEGORY: Final = BuiltCategory(
    description="a pen or a pencil",
    size=(0.0105, 0.142, 0.0145),
    min_size=(0.005, 0.06, 0.005),
    max_size=(0.03, 0.25, 0.04),
    styles={"ballpoint": Style(ballpoint), "pencil": Style(pencil, size=(0.0085, 0.175, 0.00736))},
    size_variation=STANDARD,
    support="surface",
    mass_range=(0.003, 0.04),
    words="pencil ballpoint pens pencils marker",
    schemes=(
        scheme("toy_plastic", steel="tip"),
        scheme(
            "toy_plastic", wood="wood", cavity="tip", eraser="eraser", needs="wood", weight=100.0
        ),
    ),
    construction=(row(ANY, solid(1000), "common"),),
    placements=(
        on("desk", pose="flat", count=(1, 2), weight=0.8, cluster="writing", max_groups=3),
        on("drawer", "office", pose="flat", count=(1, 3), weight=0.6),
        on(
            "coffee_table dining_table bedside worktop",
            pose="flat",
            clutter=2,
            weight=0.25,
            max_groups=1,
        ),
    ),
)
