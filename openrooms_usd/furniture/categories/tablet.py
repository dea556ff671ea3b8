"""Tablets: lying, and in a cover that is folded to a stand."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import SIDE, board, profiled, strip
from openrooms_usd.furniture.joinery.handheld import slab
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined

_LYING: Final = partial(slab, corner=0.012, rim=0.009)


def propped(size: Size, rng: np.random.Generator) -> Parts:
    """A tablet that leans on its cover."""
    width, depth, height = size
    lean = np.arctan2(0.55 * depth, height)
    tall = (height - 0.0075 * np.sin(lean) - 0.003) / np.cos(lean)
    parts = _LYING((width, tall, 0.0075), rng)
    stand: Parts = {}
    for name, mesh in parts.items():
        upright = turned(mesh.moved((0.0, 0.5 * tall, 0.0)), "x", 90.0 - float(np.degrees(lean)))
        stand[name] = upright.moved((0.0, -0.5 * depth + 0.02, 0.003))
    flap = board((-0.5 * width, -0.5 * depth, 0.0), (0.5 * width, 0.5 * depth, 0.003), 0.0008)
    foot, head = 0.5 * depth - 0.004, 0.5 * height
    y = -0.5 * depth + 0.02 + np.tan(lean) * (head - 0.003) + 0.001
    line = np.array([(foot, 0.002), (y, head)])
    prop = profiled(strip(line, 0.0025), width, SIDE, 0.0)
    return {**stand, "cover": joined([flap, prop])}


CATEGORY: Final = BuiltCategory(
    description="a tablet computer",
    size=(0.178, 0.25, 0.0075),
    min_size=(0.1, 0.05, 0.005),
    max_size=(0.4, 0.4, 0.3),
    styles={
        "lying": Style(_LYING, lambda size: size[2] < 0.03),
        "propped": Style(propped, lambda size: size[2] > 0.05, (0.25, 0.15, 0.165)),
    },
    size_variation=STANDARD,
    support="surface",
    mass_range=(0.3, 1.0),
    words="ipad tablet_computer e_reader",
    classes=Classes(ade20k="computer"),
    schemes=(
        scheme("aluminium", membrane="cover", weight=2.0),
        scheme("black_plastic", hide="cover"),
    ),
    construction=(row("cover", filled(700), "weight"), row(ANY, filled(1400), "weight")),
    placements=(
        on(
            "coffee_table desk bedside sofa_seat",
            styles="lying",
            pose="flat",
            weight=0.25,
            max_groups=1,
        ),
        on(
            "worktop dining_table", "kitchen", styles="propped", weight=0.2, clutter=2, max_groups=1
        ),
    ),
)
