"""The walls of RoomPlan that are not on the floor's outline: inside it they are partitions."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedPartition, Confidence
from orusd_scans.floorplan import TWIN_DISTANCE_M
from orusd_scans.roomplan.records import Record
from orusd_scans.roomplan.spaces import facets, placed, rectangle

if TYPE_CHECKING:
    from shapely import LineString, Polygon


# What stays nearer to the outline than this is the outline, seen inexactly, metres.
_MIN_OFF_M: Final = 0.2
# Pieces shorter than this are noise, metres.
_MIN_LENGTH_M: Final = 0.2
# Places at which a piece is held against the outline.
_SAMPLES: Final = 33
# Of a wall that is outside the floor: more is said, metres.
_MAX_CUT_M: Final = 0.3
# Two walls back to back are both faces of one: how far they are apart, metres, how parallel they
# are, and how much of the shorter lies beside the other.
_MAX_THICKNESS_M: Final = 0.5
_MIN_THICKNESS_M: Final = 0.03
_MIN_PARALLEL_COS: Final = 0.98
_MIN_BESIDE_SHARE: Final = 0.5


@dataclass(frozen=True, eq=False)
class InnerWalls:
    """What stands inside a floor.

    Attributes:
        partitions: The walls.
        names: For each wall of the source that became a part of some: which.
    """

    partitions: tuple[CapturedPartition, ...] = ()
    names: Mapping[str, tuple[str, ...]] | None = None

    def wall_of(self, parent: str | None) -> str | None:
        """The wall that an opening is in, by its wall in the source; None where that is open."""
        if parent is None or not self.names or parent not in self.names:
            return parent
        known = self.names[parent]
        return known[0] if len(known) == 1 else None


@dataclass(frozen=True, eq=False)
class _Piece:
    """A straight part of a wall inside the floor.

    Attributes:
        ids: The walls of the source that it is made of.
        ends: (2, 2) metres.
        top: Height of its top, metres.
        confidence: How sure the source is.
        thickness: Metres; None when unknown.
    """

    ids: tuple[str, ...]
    ends: Array
    top: float
    confidence: Confidence | None
    thickness: float | None = None

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    @property
    def along(self) -> Array:
        return np.asarray((self.ends[1] - self.ends[0]) / self.length)


def inner_walls(
    walls: Sequence[Record], floor: Array, to_world: Callable[[Array], Array], notes: list[str]
) -> InnerWalls:
    """The walls that stand inside a floor.

    Args:
        walls: All walls of the room.
        floor: (N, 2) the corners of its floor in the world, metres.
        to_world: Takes points (..., 3) of the source to the world.
        notes: Receives a sentence for the walls that are left out, and for each that is cut.
    """
    import shapely

    polygon = shapely.Polygon(floor)
    pieces: list[_Piece] = []
    outside: list[str] = []
    for wall in walls:
        top = float(to_world(placed(wall, rectangle(wall)))[:, 2].max())
        path = shapely.LineString(to_world(facets(wall))[:, :2])
        lines = _inside(path, polygon)
        beyond = path.difference(polygon.buffer(TWIN_DISTANCE_M)).length
        pieces += [_Piece((wall.id,), line, top, wall.confidence) for line in lines]
        if beyond > _MAX_CUT_M and lines:
            notes.append(
                f"the inner wall {wall.id} is {path.length:.2f} m long: {beyond:.2f} m of "
                "it are outside the floor and left out"
            )
        elif beyond > min(_MAX_CUT_M, 0.5 * path.length):
            outside.append(f"{wall.id} ({path.length:.2f} m)")
    if outside:
        words = "wall that is" if len(outside) == 1 else "walls that are"
        notes.append(f"left out {len(outside)} {words} outside the floor: {', '.join(outside)}")
    return _named(_paired(pieces))


def _inside(path: "LineString", polygon: "Polygon") -> list[Array]:
    """(2, 2) the straight parts of a wall inside a floor that are not on its outline."""
    import shapely
    from shapely.ops import substring

    edge = polygon.boundary
    free = path.intersection(polygon).difference(edge.buffer(TWIN_DISTANCE_M))
    found = []
    for part in shapely.get_parts(free):
        if not isinstance(part, shapely.LineString) or part.length == 0.0:
            continue
        places = np.linspace(0.0, 1.0, _SAMPLES)
        points = shapely.line_interpolate_point(part, places, normalized=True)
        if shapely.distance(points, edge).max() < _MIN_OFF_M:
            continue
        # As far as the outline, or as its own ends.
        start, stop = (path.project(shapely.Point(part.coords[i])) for i in (0, -1))
        low, high = min(start, stop) - TWIN_DISTANCE_M, max(start, stop) + TWIN_DISTANCE_M
        whole = substring(path, max(low, 0.0), min(high, path.length))
        corners = shapely.get_coordinates(whole)
        if whole.length >= _MIN_LENGTH_M:
            found += list(np.stack([corners[:-1], corners[1:]], axis=1))
    return found


def _paired(pieces: Sequence[_Piece]) -> list[_Piece]:
    """Pieces of which two that are both faces of one wall became one, the longest first."""
    rest = sorted(pieces, key=lambda piece: -piece.length)
    made = []
    while rest:
        one = rest.pop(0)
        other = next((piece for piece in rest if _are_faces(one, piece)), None)
        if other is not None:
            rest.remove(other)
            one = _between(one, other)
        made.append(one)
    return made


def _beside(one: _Piece, other: _Piece) -> tuple[Array, Array]:
    """(2,) how far along a piece the ends of another are, and (2,) how far beside it."""
    offsets = other.ends - one.ends[0]
    x, y = one.along
    return offsets @ one.along, offsets @ np.array([-y, x])


def _are_faces(one: _Piece, other: _Piece) -> bool:
    along, off = _beside(one, other)
    common = min(float(along.max()), one.length) - max(float(along.min()), 0.0)
    return (
        abs(float(one.along @ other.along)) > _MIN_PARALLEL_COS
        and abs(float(off.mean())) < _MAX_THICKNESS_M
        and common > _MIN_BESIDE_SHARE * other.length
    )


def _between(one: _Piece, other: _Piece) -> _Piece:
    """The wall whose faces two pieces are."""
    along, off = _beside(one, other)
    x, y = one.along
    reach = np.array([min(float(along.min()), 0.0), max(float(along.max()), one.length)])
    middle = one.ends[0] + 0.5 * float(off.mean()) * np.array([-y, x])
    depth = abs(float(off.mean()))
    return _Piece(
        (*one.ids, *other.ids),
        middle + reach[:, None] * one.along,
        max(one.top, other.top),
        one.confidence,
        depth if depth > _MIN_THICKNESS_M else None,
    )


def _named(pieces: Sequence[_Piece]) -> InnerWalls:
    """The pieces by the identifiers of their walls; several of one wall are numbered."""
    counts: dict[str, int] = {}
    names: dict[str, tuple[str, ...]] = {}
    made = []
    several = [piece.ids[0] for piece in pieces]
    for piece in pieces:
        name, number = piece.ids[0], counts.get(piece.ids[0], 0)
        counts[name] = number + 1
        name = f"{name} {number}" if several.count(name) > 1 else name
        for wall in piece.ids:
            names[wall] = (*names.get(wall, ()), name)
        made.append(
            CapturedPartition(name, piece.ends, piece.thickness, piece.top, piece.confidence)
        )
    return InnerWalls(tuple(made), names)
