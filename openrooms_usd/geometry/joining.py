"""Rooms that stand wall to wall, as one: the outline of them all, and the walls between them."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.polygons import CLEARANCE

Edge = tuple[int, int]
"""The number of a floor, and of the edge from that corner of it to the next one."""

MAX_WALL_M: Final = 0.5
"""Floors up to this far apart have a wall between them, metres: thick old ones."""

# How parallel both faces of a wall are, how far floors may overlap by inexact measuring, and how
# much of them lies face to face, metres.
_MIN_PARALLEL_COS: Final = 0.98
_MAX_OVERLAP_M: Final = 0.1
_MIN_COMMON_M: Final = 0.2
# Nothing thinner is built, metres.
_MIN_THICKNESS_M: Final = 0.03
# Pieces of one wall are in line to this, and as thick to that, metres.
_SAME_LINE_M: Final = 0.05
_SAME_THICKNESS_M: Final = 0.1
# Gaps between walls that are too narrow for a passage, metres.
_MAX_SLIT_M: Final = 0.15


@dataclass(frozen=True, eq=False)
class WallBetween:
    """A straight wall between floors.

    Attributes:
        ends: (2, 2) of its middle line, metres.
        thickness: Metres.
        sides: The edges of floors that are its faces.
    """

    ends: Array
    thickness: float
    sides: tuple[Edge, ...]

    @property
    def length(self) -> float:
        """Of the middle line, metres."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    @property
    def along(self) -> Array:
        """(2,) unit vector from the first end to the second."""
        return np.asarray((self.ends[1] - self.ends[0]) / self.length)

    def place(self, points: Array) -> tuple[Array, Array]:
        """(N,) how far along it points (N, 2) are, and (N,) how far to the left of it."""
        x, y = self.along
        offsets = points - self.ends[0]
        return offsets @ self.along, offsets @ np.array([-y, x])


def joined_floors(floors: Sequence[Array], first: int) -> tuple[Array, list[int]] | None:
    """The outline of the floors that touch one of them, or are a wall's thickness apart.

    Args:
        floors: Each (N, 2) corners, metres.
        first: Which one.

    Returns:
        (K, 2) corners, with holes filled, and which floors they enclose; None for one alone.
    """
    import shapely

    shapes = [shapely.make_valid(shapely.Polygon(floor)) for floor in floors]
    half = 0.5 * MAX_WALL_M + CLEARANCE
    members, rest = [first], [i for i in range(len(shapes)) if i != first]
    while touching := [
        i for i in rest if any(shapes[i].distance(shapes[k]) <= MAX_WALL_M for k in members)
    ]:
        members += touching
        rest = [i for i in rest if i not in touching]
    if len(members) == 1:
        return None
    area = shapely.union_all([shapes[i] for i in members])
    closed = area.buffer(half, join_style="mitre").buffer(-half, join_style="mitre")
    # Only what lies between two floors is wall: niches of one stay open.
    between = [
        gap
        for gap in shapely.get_parts(shapely.difference(closed, area))
        if sum(shapes[i].distance(gap) <= CLEARANCE for i in members) > 1
    ]
    whole = shapely.union_all([area, *between]).buffer(CLEARANCE, join_style="mitre")
    largest = max(shapely.get_parts(whole), key=lambda part: part.area)
    ring = largest.buffer(-CLEARANCE, join_style="mitre").simplify(CLEARANCE).exterior
    return shapely.get_coordinates(ring)[:-1], sorted(members)


def walls_between(
    floors: Sequence[Array], unseen: Collection[Edge] = ()
) -> tuple[WallBetween, ...]:
    """The walls whose faces are edges of two floors, the longest first.

    Args:
        floors: Each (N, 2) corners, counter-clockwise, metres.
        unseen: Edges without a scanned wall: nothing stands between two of them.
    """
    pieces = [
        piece
        for other in range(len(floors))
        for one in range(other)
        for piece in _facing(one, floors[one], other, floors[other])
        if not all(edge in unseen for edge in piece.sides)
    ]
    return tuple(_meeting(_in_line(pieces)))


def _facing(one: int, floor: Array, other: int, beyond: Array) -> Iterator[WallBetween]:
    """The walls between two floors, as far as their faces lie before each other."""
    steps, away = (np.roll(corners, -1, axis=0) - corners for corners in (floor, beyond))
    lengths = np.linalg.norm(steps, axis=1)
    unit = steps / lengths[:, None]
    opposite = unit @ (away / np.linalg.norm(away, axis=1)[:, None]).T < -_MIN_PARALLEL_COS
    for i, k in np.argwhere(opposite).tolist():
        outward = np.array([unit[i, 1], -unit[i, 0]])
        ends = np.array([beyond[k], beyond[k] + away[k]]) - floor[i]
        apart, along = float((ends @ outward).mean()), ends @ unit[i]
        low, high = max(float(along.min()), 0.0), min(float(along.max()), float(lengths[i]))
        if -_MAX_OVERLAP_M < apart <= MAX_WALL_M and high - low > _MIN_COMMON_M:
            middle = floor[i] + 0.5 * apart * outward
            line = middle + np.array([low, high])[:, None] * unit[i]
            yield WallBetween(line, max(apart, _MIN_THICKNESS_M), ((one, i), (other, k)))


def _in_line(pieces: Sequence[WallBetween]) -> list[WallBetween]:
    """Pieces with those in line with them as one, the longest first; none leads across another."""
    rest = sorted(pieces, key=lambda piece: -piece.length)
    made: list[WallBetween] = []
    while rest:
        wall = rest.pop(0)
        while (more := next((p for p in rest if _continues(wall, p, made)), None)) is not None:
            rest.remove(more)
            wall = _both(wall, more)
        made.append(wall)
    return made


def _continues(wall: WallBetween, piece: WallBetween, others: Sequence[WallBetween]) -> bool:
    import shapely

    along, off = wall.place(piece.ends)
    gap = max(float(along.min()) - wall.length, -float(along.max()))
    if (
        np.abs(off).max() > _SAME_LINE_M
        or abs(wall.thickness - piece.thickness) > _SAME_THICKNESS_M
        or gap > MAX_WALL_M
    ):
        return False
    whole = shapely.LineString(_both(wall, piece).ends)
    return not any(whole.intersects(shapely.LineString(other.ends)) for other in others)


def _both(wall: WallBetween, piece: WallBetween) -> WallBetween:
    along, _ = wall.place(piece.ends)
    reach = np.array([min(float(along.min()), 0.0), max(float(along.max()), wall.length)])
    weights = [wall.length, piece.length]
    thickness = float(np.average([wall.thickness, piece.thickness], weights=weights))
    sides = tuple(dict.fromkeys((*wall.sides, *piece.sides)))
    return WallBetween(wall.ends[0] + reach[:, None] * wall.along, thickness, sides)


def _meeting(walls: Sequence[WallBetween]) -> Iterator[WallBetween]:
    """The walls, prolonged to the middle lines of those that they lead to."""
    for wall in walls:
        low, high = (
            min((ahead for o in walls if (ahead := _ahead(wall, o, end)) is not None), default=0.0)
            for end in (0, 1)
        )
        reach = np.array([-low, wall.length + high])
        yield WallBetween(wall.ends[0] + reach[:, None] * wall.along, wall.thickness, wall.sides)


def _ahead(wall: WallBetween, other: WallBetween, end: int) -> float | None:
    """How far before one end of a wall the middle line of another crosses its own; None if not."""
    away = wall.along if end else -wall.along
    _, off = other.place(wall.ends)
    _, steep = other.place(other.ends[0] + away[None])
    if abs(float(steep[0])) < 1.0 - _MIN_PARALLEL_COS:
        return None
    ahead = -float(off[end] / steep[0])
    station = float(other.place((wall.ends[end] + ahead * away)[None])[0][0])
    beside = 0.5 * wall.thickness + _MAX_SLIT_M
    near = -beside <= station <= other.length + beside
    return ahead if near and 0.0 < ahead <= 0.5 * other.thickness + _MAX_SLIT_M else None
