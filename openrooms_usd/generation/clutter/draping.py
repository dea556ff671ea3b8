"""Cloths over edges: towels over rails, throws over the arms of sofas, a cloth over a chair's back.

What hangs down on both sides of an edge is made to fit it: as deep as the edge is thick, with a
flap on either side (`openrooms_usd.furniture.placements`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import offered_surfaces
from openrooms_usd.furniture.placements import DRAPED_WALL_M, Place
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.levels import along_edges
from openrooms_usd.generation.items import Item

# The shorter flap as a share of the longer one, with a little more to be sure.
_SHORTER_SHARE: Final = 0.66
# Between cloth and edge: above it, and on either side; metres.
_ABOVE_M, _BESIDE_M = 0.001, 0.002
# What is so far aside of a cloth counts as below it, and what is so far within its ends carries it,
# metres.
_ASIDE_M, _WITHIN_M = 0.005, 0.03
# Posts are at least this much higher than the edge between them; cloths have at least this width.
# Metres.
_POST_M, _NARROWEST_M = 0.003, 0.16
# What a cloth may hang over, metres.
_THINNEST_M, _THICKEST_M = 0.016, 0.28
_LEAST_DROP_M: Final = 0.15


class Way(NamedTuple):
    """Where the longer flap of a cloth hangs.

    Attributes:
        out: Direction of that flap in the carrier's frame: 0 to its front, 90 to its right.
        reach: Least and greatest place of the edge in that direction, as shares of the size there.
        along: Least and greatest middle of the cloth along the edge, as shares of the size there.
        share: Of the edge's length that a cloth may have.
    """

    out: float
    reach: tuple[float, float]
    along: tuple[float, float]
    share: float


_WAYS: Final[dict[Place, tuple[Way, ...]]] = {
    # Between the posts of the rail.
    "towel_rail": (Way(0.0, (-0.5, 0.5), (-0.07, 0.07), 0.62),),
    "chair_back": (Way(180.0, (0.1, 0.55), (-0.05, 0.05), 0.8),),
    "sofa_arm": (
        Way(90.0, (0.3, 0.52), (-0.2, 0.05), 0.5), Way(-90.0, (0.3, 0.52), (-0.05, 0.2), 0.5),
    ),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Edge:
    """Something that cloths hang over.

    Attributes:
        place: ``towel_rail``, ``chair_back`` or ``sofa_arm``.
        carrier: What it belongs to.
        group: The index of the group of the carrier.
        points: (N, 3) dense points of the carrier, in its own frame; metres.
    """

    place: Place
    carrier: Item
    group: int
    points: Array


class Fit(NamedTuple):
    """How a cloth hangs.

    Attributes:
        size: Width, depth and height that it is made to, metres.
        x: Middle of its base in the carrier's frame, metres.
        y: Likewise.
        z: Height of its base above the carrier's, metres.
        yaw: In the carrier's frame, degrees.
    """

    size: tuple[float, float, float]
    x: float
    y: float
    z: float
    yaw: float


def edges(groups: Sequence[tuple[str, Sequence[Item]]], surfaces: LevelFinder) -> Iterator[Edge]:
    """All edges of a furnished room that cloths may hang over."""
    for number, (_, items) in enumerate(groups):
        for item in items:
            offered = offered_surfaces(item.category)
            for place in (place for place in offered if place in _WAYS):
                yield Edge(place, item, number, along_edges(surfaces.shape(item).corners))


def hang_over(
    edge: Edge, width: float, height: float, rng: np.random.Generator
) -> Fit | None:  # fmt: skip
    """How a cloth of a width and a longer flap hangs over an edge; None where it does not.

    Args:
        edge: The edge.
        width: Metres.
        height: Of the longer flap, metres.
        rng: Draws the side and the place along the edge.
    """
    ways = _WAYS[edge.place]
    way = ways[int(rng.integers(len(ways)))]
    turn = np.radians(way.out - 90.0)
    out, along = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    deep, long = (float(np.abs(axis) @ edge.carrier.size[:2]) for axis in (out, along))
    v0 = float(rng.uniform(*way.along)) * long
    u, v, z = edge.points[:, :2] @ out, edge.points[:, :2] @ along, edge.points[:, 2]
    over = (u >= way.reach[0] * deep) & (u <= way.reach[1] * deep)
    width = round(min(width, way.share * long), 2)
    width = _between_posts(width, np.abs(v[over] - v0), z[over])
    near = np.abs(v - v0) <= 0.5 * width + _ASIDE_M
    there = near & over
    if not there.any():
        return None
    top = float(z[there].max())
    height = round(min(height, 0.85 * (top + edge.carrier.z)), 2)
    outer = there & (z > top - height)
    inner = near & (z > top - _SHORTER_SHARE * height) & (u <= float(u[outer].max()))
    low, high = float(u[inner].min()), float(u[outer].max())
    thick = max(high - low, _THINNEST_M)
    if thick > _THICKEST_M or height < _LEAST_DROP_M:
        return None
    depth = round(thick + 2 * (DRAPED_WALL_M + _BESIDE_M), 3)
    middle = 0.5 * (low + high)
    if edge.place == "towel_rail" and 0.5 * deep - abs(low) < DRAPED_WALL_M + _BESIDE_M:
        return None
    x, y = (middle * out + v0 * along).tolist()
    base = top + DRAPED_WALL_M + _ABOVE_M - height
    return Fit((width, depth, height), x, y, base, way.out)


def _between_posts(width: float, aside: Array, z: Array) -> float:
    """A cloth's width, less where it would meet posts at its ends that are higher than the edge.

    Args:
        width: Metres.
        aside: (N,) how far points of the edge are from its middle, metres.
        z: (N,) how high they are, metres.
    """
    while width > _NARROWEST_M:
        top = z[aside <= 0.5 * width + _ASIDE_M].max(initial=-np.inf)
        inner = z[aside <= 0.5 * width - _WITHIN_M].max(initial=-np.inf)
        if top - inner <= _POST_M:
            break
        width = round(width - _ASIDE_M, 3)
    return width
