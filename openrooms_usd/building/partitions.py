"""Walls that stand free in a room: how they meet its walls and each other.

A partition is given by its middle line. An end at a wall is cut off along the wall's inner face, an
end at the side of another partition along that partition's face. Where ends meet, each takes what
is nearer to its own line. So nothing stays open between them, no partition reaches into a wall, and
every outline is convex.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.walls import MITRE_LIMIT, Wall, half_plane
from openrooms_usd.geometry.floorplan import inside, wall_distance

REACH_M: Final = 0.15
"""Gaps up to this length between a partition's end and what it leads to are closed, metres: real
rooms have no such slits."""

# What must be left of a partition's faces, metres.
_MIN_LENGTH_M: Final = 0.05
# Partitions that leave their common end at less than this angle lie over each other, degrees.
_MIN_JOINT_DEG: Final = 15.0


@dataclass(frozen=True, eq=False)
class Partition:
    """A wall that stands free in a room.

    Attributes:
        name: Its prim name.
        ends: (2, 2) of its middle line in the plan, metres.
        thickness: Half of it to each side of the line, metres.
        height: Metres; None for one that reaches the ceiling.
    """

    name: str
    ends: Array
    thickness: float
    height: float | None = None

    @property
    def length(self) -> float:
        """Of the middle line, metres."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    @property
    def along(self) -> Array:
        """(2,) unit vector from the first end to the second."""
        return np.asarray((self.ends[1] - self.ends[0]) / self.length)

    @property
    def across(self) -> Array:
        """(2,) unit vector to the left of it."""
        x, y = self.along
        return np.array([-y, x])


class _Limit(NamedTuple):
    """A half plane: the points p of the plan where ``normal . p <= reach``."""

    normal: Array
    reach: float


def misplaced(partition: Partition, corners: Array) -> str | None:
    """Say why a partition cannot stand in a room.

    Args:
        partition: The wall.
        corners: (N, 2) the room's polygon, metres.

    Returns:
        A phrase that follows its name, or None when it can.
    """
    if partition.length < _MIN_LENGTH_M:
        return f"is only {partition.length:.3f} m long"
    # Pieces of its line between crossings lie inside or outside as a whole.
    cuts = [d for d, _ in _crossings(partition.ends[0], partition.along, corners)]
    stops = np.unique(np.clip([0.0, *cuts, partition.length], 0.0, partition.length))
    middles = partition.ends[0] + 0.5 * (stops[1:] + stops[:-1])[:, None] * partition.along
    reach = 0.5 * partition.thickness + REACH_M
    away = ~inside(corners, middles) & (wall_distance(corners, middles) > 0.5 * reach)
    if (away & (np.diff(stops) > reach)).any():
        return "does not lie inside the room"
    start, end = partition.ends
    beside = np.linspace(start, end, 9)[1:-1]
    if (wall_distance(corners, beside) < 0.5 * partition.thickness).all():
        return "lies along a wall"
    return None


def partition_walls(partitions: Sequence[Partition], corners: Array) -> tuple[Wall, ...]:
    """The partitions of a room as walls; one of which nothing is left is left out.

    A partition is seen from the side from which its line runs to the right.

    Args:
        partitions: Those that can stand in the room.
        corners: (N, 2) the room's polygon, counter-clockwise, metres.
    """
    made = (_wall(i, partitions, corners) for i in range(len(partitions)))
    return tuple(wall for wall in made if wall is not None)


def _wall(index: int, partitions: Sequence[Partition], corners: Array) -> Wall | None:
    one = partitions[index]
    left, reach = one.ends[0] - 0.5 * one.thickness * one.across, 3.0 * (one.thickness + REACH_M)
    low, high, far = -reach, one.length + reach, one.thickness
    ring = np.array([[low, 0.0], [high, 0.0], [high, far], [low, far]])
    for end in (0, 1):
        for limit in _limits(index, end, partitions, corners):
            normal = (float(limit.normal @ one.along), float(limit.normal @ one.across))
            ring = half_plane(ring, normal, limit.reach - float(limit.normal @ left))
            if len(ring) < 3:
                return None
    faces = [ring[ring[:, 1] == y, 0] for y in (0.0, far)]
    if any(len(x) < 2 or np.ptp(x) < _MIN_LENGTH_M for x in faces):
        return None
    begin, stop = float(faces[0].min()), float(faces[0].max())
    first = int(np.flatnonzero((ring[:, 1] == 0.0) & (ring[:, 0] == begin))[0])
    outline = np.roll(ring, -first, axis=0) - [begin, 0.0]
    start, end = (left + x * one.along for x in (begin, stop))
    return Wall(index, start, end, far, outline, 0.0, one.name, one.height)


def _limits(
    index: int, end: int, partitions: Sequence[Partition], corners: Array
) -> Iterator[_Limit]:
    """What cuts a partition off at one of its ends."""
    one = partitions[index]
    tip, away = one.ends[end], one.along if end else -one.along
    found = [*_at_walls(one, tip, away, corners), *_at_sides(index, tip, partitions)]
    yield from found
    joint = _joint(index, end, partitions)
    if joint is not None:
        place, others = joint
        yield from (_nearer(place, -away, other) for other in others)
        yield _square(away, place + MITRE_LIMIT * one.thickness * away)
    elif not found:
        yield _square(away, tip)


def _square(away: Array, place: Array) -> _Limit:
    return _Limit(away, float(away @ place))


def _nearer(place: Array, one: Array, other: Array) -> _Limit:
    """What is nearer to one ray from a place than to another."""
    normal = (other - one) / np.linalg.norm(other - one)
    return _Limit(normal, float(normal @ place))


def _at_walls(one: Partition, tip: Array, away: Array, corners: Array) -> Iterator[_Limit]:
    """The inner faces through which a partition would leave the room at its tip."""
    near = [
        (distance, edge)
        for distance, edge in _crossings(tip, away, corners)
        if abs(distance) <= REACH_M + 0.5 * one.thickness
    ]
    nearest = min((abs(distance) for distance, _ in near), default=0.0)
    for distance, edge in near:
        ahead = np.roll(corners, -1, axis=0)[edge] - corners[edge]
        outward = np.array([ahead[1], -ahead[0]]) / np.linalg.norm(ahead)
        # In a corner both walls count.
        if outward @ away > 0.0 and abs(distance) <= nearest + one.thickness:
            yield _Limit(outward, float(outward @ corners[edge]))


def _crossings(start: Array, along: Array, corners: Array) -> list[tuple[float, int]]:
    """Where a line meets the edges of a polygon: distances from its start, and the edges."""
    steps = np.roll(corners, -1, axis=0) - corners
    offsets = corners - start
    slope = along[0] * steps[:, 1] - along[1] * steps[:, 0]
    lengths = np.linalg.norm(steps, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (offsets[:, 0] * steps[:, 1] - offsets[:, 1] * steps[:, 0]) / slope
        share = (offsets[:, 0] * along[1] - offsets[:, 1] * along[0]) / slope
    # A line into a corner meets both of its edges, whatever is rounded.
    slack = 1e-6 / lengths
    meets = (np.abs(slope) > 1e-6 * lengths) & (share >= -slack) & (share <= 1.0 + slack)
    return [(float(distance[i]), int(i)) for i in np.flatnonzero(meets)]


def _at_sides(index: int, tip: Array, partitions: Sequence[Partition]) -> Iterator[_Limit]:
    """The faces of other partitions at which this one ends."""
    one = partitions[index]
    for other in (p for i, p in enumerate(partitions) if i != index):
        x, y = (tip - other.ends[0]) @ np.array([other.along, other.across]).T
        side = float(np.sign((one.ends.mean(axis=0) - other.ends[0]) @ other.across))
        is_beside = REACH_M < x < other.length - REACH_M
        steep = abs(float(one.along @ other.across)) > np.sin(np.radians(_MIN_JOINT_DEG))
        if side and is_beside and steep and abs(y) <= REACH_M + 0.5 * other.thickness:
            face = other.ends[0] + 0.5 * side * other.thickness * other.across
            yield _Limit(-side * other.across, float(-side * other.across @ face))


def _joint(
    index: int, end: int, partitions: Sequence[Partition]
) -> tuple[Array, list[Array]] | None:
    """Where other partitions end at the same place: that place, and where they lead from it."""
    one = partitions[index]
    tip, back = one.ends[end], -one.along if end else one.along
    lines, others = [(tip, one.across)], []
    for other in (p for i, p in enumerate(partitions) if i != index):
        for there, leads in ((other.ends[0], other.along), (other.ends[1], -other.along)):
            apart = float(np.degrees(np.arccos(np.clip(back @ leads, -1.0, 1.0))))
            if np.linalg.norm(there - tip) <= REACH_M and apart > _MIN_JOINT_DEG:
                lines.append((there, other.across))
                others.append(leads)
    if not others:
        return None
    # The point nearest to all the lines; of parallel ones that nearest to their ends.
    middle = np.mean([place for place, _ in lines], axis=0)
    normals = np.array([normal for _, normal in lines])
    off = np.array([normal @ (place - middle) for place, normal in lines])
    return middle + np.linalg.pinv(normals, rcond=np.sin(np.radians(_MIN_JOINT_DEG))) @ off, others
