"""Apple RoomPlan: its exports become Captures.

The world frame is Z up with the floor at 0. Its X axis runs along the longest wall, the way that
needs the least rotation, and the room lies at positive x and y: numbers that people can write
down, however far from the origin the source is.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.capture import (
    NO_OPTIONS,
    Capture,
    CapturedBox,
    CapturedOpening,
    CapturedPartition,
    Confidence,
)
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import about_z
from orusd_scans.floorplan import TWIN_DISTANCE_M, from_lower_left, heading, tidied
from orusd_scans.roomplan.heights import ceiling_over
from orusd_scans.roomplan.records import CapturedRoom, Record, read_captured_rooms
from orusd_scans.roomplan.spaces import Z_UP, chosen_space, facets, placed, rectangle
from orusd_scans.worldframe import WorldFrame

if TYPE_CHECKING:
    from shapely import LineString, Polygon


# Columns: our right, back and up in RoomPlan's object axes, which are right, up and front.
_BOX_AXES: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
# Openings nearer to each other than this part of their width are duplicates.
_SAME_OPENING_SHARE: Final = 0.25
_CONFIDENCE: Final = {"high": 2, "medium": 1, "low": 0, None: -1}


class RoomPlanImporter:
    """Reads an export of Apple RoomPlan: JSON, or parametric USDZ."""

    options: Mapping[str, str] = {
        "room": "which room: its label, such as livingRoom, its number, or all of a storey as one; "
        "by default the largest"
    }

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read a CapturedRoom or a CapturedStructure.

        Args:
            source: The JSON or USDZ file.
            options: ``room``: which room of several is meant.

        Raises:
            InputError: It is missing, is not such a file, holds nonsense, or has no such room;
                names the place.
        """
        notes: list[str] = []
        try:
            space = chosen_space(_rooms(source, notes), options.get("room"), notes)
        except InputError as error:
            error.place = error.place or str(source)
            raise
        room, frame = space.records, _frame(space.records, space.outline)
        # Nanometres are noise of the rotation.
        outline = space.outline
        corners = None if outline is None else np.round(frame.points(outline)[:, :2], 9) + 0.0
        floor = None if corners is None else tidied(corners, notes)
        floor = None if floor is None else from_lower_left(floor)
        # Walls outside belong to other rooms, where there are any.
        told = notes if space.is_whole else []
        inner = (
            InnerWalls() if floor is None else inner_walls(room.walls, floor, frame.points, told)
        )
        others = (*(inner.names or ()), *inner.outside)
        ceiling = ceiling_over(floor, room.walls, others, frame, notes)
        openings = [
            *(_opening(record, "door", frame) for record in room.doors),
            *(_opening(record, "window", frame) for record in room.windows),
            *(_opening(record, "opening", frame) for record in room.openings),
        ]
        return Capture(
            source=source.name,
            source_from_world=frame.source_from_world(),
            floor=floor,
            height=ceiling.height,
            roof=ceiling.line,
            openings=tuple(
                replace(opening, wall=inner.wall_of(opening.wall))
                for opening in _distinct(openings, notes)
            ),
            partitions=inner.partitions,
            boxes=tuple(_box(record, frame) for record in room.objects),
            notes=tuple(notes),
            use=next(iter(space.labels), None),
        )


def _rooms(source: Path, notes: list[str]) -> list[CapturedRoom]:
    if source.suffix.lower() != ".usdz":
        return read_captured_rooms(source, notes)
    # USD takes a third of a second to import, and most captures are JSON.
    from orusd_scans.roomplan.usdz import read_usdz

    return [read_usdz(source, notes)]


def _frame(room: CapturedRoom, outline: Array | None) -> WorldFrame:
    if outline is None:
        centers = [record.center for record in (*room.walls, *room.objects)]
        return WorldFrame(Z_UP, np.mean(centers, axis=0) if centers else np.zeros(3))
    plan = (outline - outline[0]) @ Z_UP.T
    angle = heading(plan[:, :2])
    rotation = about_z(angle) @ Z_UP
    turned = (outline - outline[0]) @ rotation.T
    corner = np.array([*turned[:, :2].min(axis=0), np.median(turned[:, 2])])
    return WorldFrame(rotation, outline[0] + corner @ rotation)


def _opening(
    record: Record, kind: Literal["window", "door", "opening"], frame: WorldFrame
) -> CapturedOpening:
    direction = frame.rotation @ record.source_from_local[:3, 0]
    level = np.array([direction[0], direction[1], 0.0])
    is_open = record.details.get("isOpen")
    return CapturedOpening(
        id=record.id,
        kind=kind,
        center=frame.points(record.center),
        direction=level / max(float(np.linalg.norm(level)), 1e-12),
        width=float(record.size[0]),
        height=float(record.size[1]),
        is_open=None if is_open is None else is_open == "True",
        confidence=record.confidence,
        wall=record.parent,
    )


def _distinct(openings: list[CapturedOpening], notes: list[str]) -> list[CapturedOpening]:
    """The openings without duplicates; the one of higher confidence stays."""
    kept: list[CapturedOpening] = []
    cells: defaultdict[tuple[int, ...], list[int]] = defaultdict(list)
    side = _SAME_OPENING_SHARE * max((opening.width for opening in openings), default=1.0) + 1e-9
    for opening in openings:
        cell = np.floor(opening.center / side).astype(int)
        near = (index for place in _around(cell) for index in cells[place])
        twin = next((index for index in near if _is_same(opening, kept[index])), None)
        if twin is None:
            cells[tuple(cell.tolist())].append(len(kept))
            kept.append(opening)
            continue
        other = kept[twin]
        notes.append(f"{other.kind} {other.id} and {opening.kind} {opening.id} are one, seen twice")
        if _CONFIDENCE[opening.confidence] > _CONFIDENCE[other.confidence]:
            kept[twin] = opening
            cells[tuple(cell.tolist())].append(twin)
    return kept


def _around(cell: NDArray[np.int_]) -> Iterator[tuple[int, ...]]:
    """A cell of a grid and those that touch it."""
    yield from product(*((i - 1, i, i + 1) for i in cell.tolist()))


def _is_same(a: CapturedOpening, b: CapturedOpening) -> bool:
    near = float(np.linalg.norm(a.center - b.center)) < _SAME_OPENING_SHARE * min(a.width, b.width)
    return near and abs(float(a.direction @ b.direction)) > 0.95


def _box(record: Record, frame: WorldFrame) -> CapturedBox:
    # The source's rotations are rounded to single precision: take the nearest exact one.
    left, _, right = np.linalg.svd(frame.rotation @ record.source_from_local[:3, :3] @ _BOX_AXES)
    width, height, depth = record.size
    return CapturedBox(
        id=record.id,
        label=record.category,
        center=frame.points(record.center),
        rotation=left @ right,
        size=np.array([width, depth, height]),
        confidence=record.confidence,
        attributes=record.details,
    )


# The walls of RoomPlan that are not on the floor's outline: inside it they are partitions.

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
        outside: Walls of the source that were left out.
    """

    partitions: tuple[CapturedPartition, ...] = ()
    names: Mapping[str, tuple[str, ...]] | None = None
    outside: tuple[str, ...] = ()

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
    outside: dict[str, float] = {}
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
            outside[wall.id] = path.length
    if outside:
        words = "wall that is" if len(outside) == 1 else "walls that are"
        each = ", ".join(f"{name} ({length:.2f} m)" for name, length in outside.items())
        notes.append(f"left out {len(outside)} {words} outside the floor: {each}")
    return replace(_named(_paired(pieces)), outside=tuple(outside))


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
