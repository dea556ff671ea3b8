"""Cutting boards: a plain one, one with a handle, one with a loaf of bread on it."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.categories.bread import loaf_of, slice_of
from openrooms_usd.furniture.construction import filled, row, solid
from openrooms_usd.furniture.joinery.boards import FRONT, profiled
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.lofts import rounded_rectangle
from openrooms_usd.geometry.sweeps import extrude, tube


def plain(size: Size, rng: np.random.Generator) -> Parts:
    """A rectangular board with rounded corners."""
    width, depth, height = size
    outline = rounded_rectangle(width, depth, float(rng.uniform(0.008, 0.03)))
    return {"board": extrude(outline, height, bevel=0.002)}


def paddle(size: Size, rng: np.random.Generator) -> Parts:
    """A board that stands on its edge and ends in a handle with a thong."""
    width, thick, height = size
    low, bend = 0.74 * height, float(rng.uniform(0.1, 0.16)) * width
    half = 0.5 * width
    outline = [
        (-half, 0.0),
        (half, 0.0),
        (half, low),
        (bend, low),
        (bend, height),
        (-bend, height),
        (-bend, low),
        (-half, low),
    ]
    body = profiled(filleted(outline, 0.8 * bend, closed=True), thick - 0.0014, FRONT, 0.002)
    z = height - 0.7 * bend
    thong = [
        (0.011 * np.cos(a), -0.5 * thick + 0.0014, z + 0.012 * np.sin(a))
        for a in np.linspace(0, 2 * np.pi, 13)[:-1]
    ]
    return {
        "board": body.moved((0.0, 0.0007, 0.0)),
        "cord": tube(thong, 0.0014, segments=6, closed=True),
    }


def bread(size: Size, rng: np.random.Generator) -> Parts:
    """A board with a loaf that is cut into, and its slices."""
    width, depth, height = size
    thick = 0.018
    loaf = min(0.24, 0.55 * width)
    parts = {
        "board": extrude(rounded_rectangle(width, depth, 0.012), thick, bevel=0.002),
        "bread": loaf_of((loaf, 0.55 * depth, height - thick), rng, cut=True).moved(
            (0.5 * width - 0.5 * loaf - 0.02, 0.0, thick)
        ),
    }
    left = 0.5 * width - loaf - 0.02
    slices = []
    for k in range(int(rng.integers(1, 4))):
        # Slices that fell over: the lowest flat, the others on it.
        piece = slice_of(0.52 * depth, 0.9 * (height - thick), 0.012)
        lying = turned(piece, "y", 90.0)
        away = left - 0.011 - 0.45 * (height - thick) - 0.008 * k
        slices.append(lying.moved((away, float(rng.uniform(-0.01, 0.01)), thick + 0.0125 * k)))
    return {**parts, **numbered("slice", slices)}


CATEGORY: Final = BuiltCategory(
    description="a board to cut food on",
    size=(0.36, 0.25, 0.02),
    min_size=(0.12, 0.01, 0.006),
    max_size=(0.7, 0.6, 0.7),
    styles={
        "plain": Style(plain, lambda size: size[2] < 0.06 and size[1] > 0.05),
        "paddle": Style(paddle, lambda size: size[1] < 0.05, (0.19, 0.02, 0.42)),
        "bread": Style(bread, lambda size: size[2] > 0.06, (0.42, 0.24, 0.13), mass_range=(1.2, 4)),
    },
    support="surface",
    mass_range=(0.4, 3),
    words="chopping_board breadboard chopping_boards",
    schemes=(scheme("board_wood", hide="cord", crust="bread", crumb="slice"),),
    construction=(
        row("bread slice", filled(280), "common"),
        row("board", solid(650), "common"),
        row("cord", solid(900), "common"),
    ),
    placements=(
        on("worktop", pose="on_back", styles="paddle", cluster="cooking", weight=0.7),
        on("worktop", styles="plain bread", cluster="cooking", weight=0.8, max_groups=1),
        on("dining_table", "kitchen dining_room", styles="bread", weight=0.25, max_groups=1),
    ),
)
