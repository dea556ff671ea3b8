"""Stairs: solid steps, open treads between stringers, and with a railing. They rise backwards."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.boards import SIDE, board, profiled
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import tube

# Usual height of a step, and of a handrail above it, metres.
RISE: Final = 0.175
RAIL: Final = 0.9
TREAD: Final = 0.04


def _flight(depth: float, height: float) -> tuple[int, float, float]:
    """How many steps lead up, how deep and how high each is, metres."""
    count = max(1, round(height / RISE))
    return count, depth / count, height / count


def solid(size: Size, rng: np.random.Generator) -> Parts:
    """Closed steps: treads with a nose over risers, between boards at the sides."""
    width, depth, height = size
    count, run, rise = _flight(depth, height)
    cheek, nose, thick = 0.025, min(0.02, 0.2 * run), min(TREAD, 0.4 * rise)
    x = 0.5 * width - cheek
    treads, risers = [], []
    for i in range(count):
        y, top = -0.5 * depth + i * run, (i + 1) * rise
        lip = nose if i else 0.0
        treads.append(board((-x, y - lip, top - thick), (x, y + run, top), 0.006))
        risers.append(board((-x, y, top - rise), (x, y + 0.02, top - thick), 0.001))
    outline = [(-0.5 * depth, 0.0)]
    for i in range(count):
        y, top = -0.5 * depth + i * run, (i + 1) * rise
        outline += [(y, top), (y + run, top)]
    outline += [(0.5 * depth, 0.0)]
    side = profiled(outline, cheek, SIDE, 0.0)
    sides = [side.moved((s * 0.5 * (width - cheek), 0.0, 0.0)) for s in (-1.0, 1.0)]
    return {**numbered("step", treads), **numbered("riser", risers), **numbered("frame", sides)}


def _stringer(depth: float, height: float, tall: float, wide: float) -> "list[tuple[float, float]]":
    """The side view of a beam under the treads, level with the floor and the upper edge."""
    slope = height / depth
    front, back = -0.5 * depth, 0.5 * depth
    return [
        (front, 0.0),
        (front + tall / slope, 0.0),
        (back, height - tall),
        (back, height - 0.01),
        (back - wide, height - 0.01),
        (front, 0.01),
    ]


def open_treads(size: Size, rng: np.random.Generator) -> Parts:
    """Thick treads on two beams, with nothing between them."""
    width, depth, height = size
    count, run, rise = _flight(depth, height)
    thick, tall = min(0.05, 0.4 * rise), min(0.24, 0.5 * height)
    inset = float(rng.uniform(0.06, 0.16)) * width
    treads = [
        board(
            (-0.5 * width, -0.5 * depth + i * run - (0.02 if i else 0.0), (i + 1) * rise - thick),
            (0.5 * width, -0.5 * depth + (i + 1) * run, (i + 1) * rise),
            0.006,
        )
        for i in range(count)
    ]
    outline = np.array(_stringer(depth, height - thick, tall, 0.5 * run))
    beams = [
        profiled(outline, 0.06, SIDE, 0.003).moved((s * (0.5 * width - inset), 0.0, 0.0))
        for s in (-1.0, 1.0)
    ]
    return {**numbered("step", treads), **numbered("frame", beams)}


def railed(size: Size, rng: np.random.Generator) -> Parts:
    """Closed steps with a railing on one side or both."""
    width, depth, height = size
    climb = max(0.4 * height, height - RAIL)
    parts = solid((width, depth, climb), rng)
    count, run, rise = _flight(depth, climb)
    both = bool(rng.integers(2))
    tall = height - climb
    sides = (-1.0, 1.0) if both else ((1.0,) if rng.integers(2) else (-1.0,))
    rails, balusters, posts = [], [], []
    for s in sides:
        x = s * (0.5 * width - 0.035)
        ends = []
        for i in range(count):
            y, top = -0.5 * depth + (i + 0.5) * run, (i + 1) * rise
            balusters.append(cylinder(0.009, tall - 0.03, segments=10, base=(x, y, top - 0.002)))
            ends.append((x, y, top + tall - 0.025))
        if count > 1:
            rails.append(tube([ends[0], ends[-1]], 0.025, segments=14))
        for y, low, top in (
            (ends[0][1] - 0.3 * run, 0.0, rise + tall),
            (ends[-1][1] + 0.3 * run, climb, height),
        ):
            posts.append(board((x - 0.035, y - 0.035, low), (x + 0.035, y + 0.035, top), 0.006))
    return {
        **parts,
        **numbered("handrail", rails),
        **numbered("baluster", balusters),
        **numbered("post", posts),
    }


CATEGORY: Final = BuiltCategory(
    description="stairs up to the back",
    size=(1.0, 2.5, 2.2),
    min_size=(0.3, 0.3, 0.2),
    max_size=(4.0, 8.0, 5.0),
    styles={
        "solid": Style(solid, lambda size: size[2] < 3.3),
        "open_treads": Style(open_treads, lambda size: size[2] > 0.5),
        "railed": Style(railed, lambda size: size[2] > 2.0, (1.0, 2.6, 3.1)),
    },
    fixed=True,
    words="stairway staircase stair",
    classes=Classes(nyu40="otherstructure", ade20k="stairs"),
    schemes=(
        scheme("wood", weight=3.0),
        scheme("white", wood="step handrail", weight=2.0),
        scheme("black", wood="step"),
    ),
    view_importance=3.0,
)
