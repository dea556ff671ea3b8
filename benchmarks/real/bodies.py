"""What is wrong with the objects of a room as bodies: outside, in each other, in the air."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.real.things import PlacedObject
from benchmarks.real.truth import Frame
from benchmarks.scan.contacts import penetration
from openrooms_usd.arrays import Array

# What counts as wrong, metres: in another thing, and above what carries it.
DEEP: Final = 0.02
ABOVE: Final = 0.05
# A thing hangs where a wall or the ceiling is this near, metres.
HELD: Final = 0.10
_LOWEST: Final = 0.02  # the lowest points are those within this height, metres
_START: Final = 0.03  # a ray down starts this much above them
_LOOKS: Final = 400  # of them at most


@dataclass(frozen=True)
class BodyScore:
    """How many things are wrong.

    Attributes:
        things: All of them.
        outside: Those whose middle is outside of the outline that was found.
        pairs: Pairs that are deeper than `DEEP` in each other.
        floating: Those that are more than `ABOVE` above anything, and hang on nothing.
    """

    things: int = 0
    outside: int = 0
    pairs: int = 0
    floating: int = 0

    def __add__(self, more: "BodyScore") -> "BodyScore":
        return BodyScore(
            self.things + more.things,
            self.outside + more.outside,
            self.pairs + more.pairs,
            self.floating + more.floating,
        )


def body_score(
    things: Sequence[PlacedObject], outlines: Sequence[Array], frame: Frame, ceiling: float | None
) -> BodyScore:
    """Measure the meshes of a room.

    Args:
        things: In the capture's axes.
        outlines: (N, 2) of the rooms that were found, in the plan of `frame`.
        frame: A plan whose floor is at 0.
        ceiling: Its height, metres, if known.
    """
    import shapely

    area = shapely.union_all([shapely.make_valid(shapely.Polygon(ring)) for ring in outlines])
    bodies = [(frame.plan(t.points), t.faces) for t in things if len(t.faces)]
    middles = [frame.plan(thing.middle)[0, :2] for thing in things]
    pairs = sum(
        penetration(a, a_faces, b, b_faces) > DEEP
        for (a, a_faces), (b, b_faces) in combinations(bodies, 2)
    )
    floating = 0
    for k, (points, _) in enumerate(bodies):
        others = [body for j, body in enumerate(bodies) if j != k]
        held = area.boundary.distance(shapely.MultiPoint(points[:, :2]).convex_hull) < HELD
        hung = ceiling is not None and points[:, 2].max() > ceiling - HELD
        floating += not held and not hung and gap_below(points, others) > ABOVE
    return BodyScore(
        len(things),
        sum(not area.contains(shapely.Point(middle)) for middle in middles),
        pairs,
        floating,
    )


def gap_below(points: Array, others: Sequence[tuple[Array, NDArray[np.int64]]]) -> float:
    """How far down the first thing below some points is, or the floor at 0; metres."""
    from openrooms_usd.geometry.raycast import RayCaster

    low = points[points[:, 2] < points[:, 2].min() + _LOWEST]
    low = low[np.linspace(0, len(low) - 1, min(len(low), _LOOKS)).astype(int)]
    ground = max(float(low[:, 2].min()), 0.0)
    if ground == 0.0 or not others:
        return ground
    sizes = np.cumsum([0, *[len(some) for some, _ in others]])
    faces = [rows + start for (_, rows), start in zip(others, sizes[:-1], strict=True)]
    caster = RayCaster(np.concatenate([some for some, _ in others]), np.concatenate(faces))
    starts, down = low + np.array([0.0, 0.0, _START]), np.broadcast_to((0.0, 0.0, -1.0), low.shape)
    hits = caster.first_hit(starts, down)
    return min(ground, max(float(hits.distance.min()) - _START, 0.0))
