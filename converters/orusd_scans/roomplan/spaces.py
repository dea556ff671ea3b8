"""Selects one room of a RoomPlan export, with the records that belong to it.

A room is one scan of a structure, or one floor of a scan that has several; its labels are those of
the sections whose middles lie in it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.joining import joined_floors
from orusd_scans.floorplan import bent, chained
from orusd_scans.roomplan.records import CapturedRoom, Record

if TYPE_CHECKING:
    from shapely import Point


Z_UP: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Y up to Z up: (x, y, z) -> (x, -z, y)."""

ALL: Final = "all"
"""What asks for all rooms of a storey as one."""

# Floors whose heights differ by less than this are on one storey, metres: steps, not stairs.
_SAME_STOREY_M: Final = 1.0
# Largest distance of an opening from the wall that it is in, metres.
_IN_WALL_M: Final = 0.5
# Largest distance of a floor's walls and openings from it, metres; of objects where there are other
# floors, and of objects where there are none.
_NEAR_FLOOR_M: Final = 0.5
_OUTSIDE_FLOOR_M: Final = 0.1
_OUTSIDE_ONLY_FLOOR_M: Final = 0.5
# Heights above a floor between which the centres of its records are, metres.
_ABOVE_FLOOR_LIMITS_M: Final = (-0.5, 4.0)
_KINDS: Final = ("walls", "doors", "windows", "openings", "objects")


@dataclass(frozen=True, eq=False)
class Space:
    """A room of an export.

    Attributes:
        labels: What it is used for, as the source says.
        outline: (N, 3) the corners of its floor in the source's frame; None where walls do not
            enclose any.
        records: What belongs to it.
        notes: What was guessed.
        is_whole: Whether nothing else was captured beside it.
        story: The number of its story.
    """

    labels: tuple[str, ...]
    outline: Array | None
    records: CapturedRoom
    notes: tuple[str, ...] = ()
    is_whole: bool = True
    story: int | None = None

    @property
    def area(self) -> float:
        """Of its floor, square metres."""
        if self.outline is None:
            return 0.0
        x, z = (self.outline - self.outline[0])[:, [0, 2]].T
        return 0.5 * abs(float(x @ np.roll(z, -1) - z @ np.roll(x, -1)))

    @property
    def level(self) -> float:
        """The height of its floor in the source's frame, metres."""
        return 0.0 if self.outline is None else float(np.median(self.outline[:, 1]))

    @property
    def name(self) -> str:
        """Its labels in words."""
        return "+".join(self.labels) or "unidentified"


def chosen_space(rooms: Sequence[CapturedRoom], wanted: str | None, notes: list[str]) -> Space:
    """The requested room.

    Args:
        rooms: What the export holds.
        wanted: A label or a number; by default the largest.
        notes: Receives what was guessed, and which other rooms there are.

    Raises:
        InputError: There is no such room.
    """
    spaces = [space for room in rooms for space in _spaces(room)]
    known = ", ".join(f"{i} {s.name} ({s.area:.1f} m2)" for i, s in enumerate(spaces))
    fitting = [i for i, s in enumerate(spaces) if wanted in (None, ALL) or _is(wanted or "", i, s)]
    if not fitting:
        raise InputError(f"the capture has no room {wanted!r}", remedy=f"it has: {known}")
    index = max(fitting, key=lambda i: spaces[i].area)
    space, taken = spaces[index], f"{index} was taken"
    if wanted == ALL and len(spaces) > 1:
        space, count = _joined(spaces, index, rooms)
        taken = f"{count} of them were taken as one" if count > 1 else taken
    if space.outline is not None:
        own = len(spaces) == 1 or (len(spaces) == len(rooms) and wanted != ALL)
        records = belonging(space.records, space.outline, is_only=own)
        space = replace(space, records=records, is_whole=len(spaces) == 1)
    missing = left_out(rooms, space.records)
    if len(spaces) > 1:
        why = (
            "as asked"
            if wanted is not None
            else "the largest; the option room selects another, or all"
        )
        rest = f"; left out with the others: {missing}" if missing else ""
        notes.append(f"the capture has {len(spaces)} rooms: {known}; {taken}, {why}{rest}")
    elif missing:
        notes.append(f"left out what lies outside the floor: {missing}")
    notes += space.notes
    return space


def _joined(
    spaces: Sequence[Space], index: int, rooms: Sequence[CapturedRoom]
) -> tuple[Space, int]:
    """All rooms of the storey of one of them that touch each other, as one; and how many."""
    first = spaces[index]
    assert first.outline is not None or len(spaces) == 1
    level = first.level
    same = [s for s in spaces if s.outline is not None and abs(s.level - level) < _SAME_STOREY_M]
    base = first.outline[0] if first.outline is not None else np.zeros(3)
    plans = [(s.outline - base)[:, [0, 2]] for s in same if s.outline is not None]
    found = joined_floors(plans, same.index(first))
    if found is None:
        return first, 1
    plan, members = found
    corners = np.column_stack([plan[:, 0], np.full(len(plan), level - base[1]), plan[:, 1]]) + base
    labels = _known([label for i in members for label in same[i].labels])
    said = tuple(dict.fromkeys(note for i in members for note in same[i].notes))
    records = of_story(merged(rooms), first.story)
    return Space(labels, corners, records, said, story=first.story), len(members)


def _is(wanted: str, index: int, space: Space) -> bool:
    return wanted.strip() == str(index) or _plain(wanted) in map(_plain, space.labels)


def _plain(label: str) -> str:
    return "".join(c for c in label.casefold() if c.isalnum())


def _spaces(room: CapturedRoom) -> list[Space]:
    notes: list[str] = []
    floors = [(_floor(floor, room), floor.story) for floor in room.floors]
    if len(floors) < 2:
        labels = [section.label for section in room.sections]
        outline = floors[0][0] if floors else _from_walls(room, notes)
        if floors and not len(room.floors[0].corners):
            outline = _around(room, outline)
        story = room.floors[0].story if floors else None
        return [Space(_known(labels), outline, room, tuple(notes), story=story)]
    return [
        Space(_known(_labels_in(outline, story, room)), outline, of_story(room, story), story=story)
        for outline, story in floors
    ]


def _known(labels: Sequence[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(label for label in labels if label != "unidentified"))


def placed(record: Record, local: Array) -> Array:
    """Local points (N, 3) of a record in the source's frame."""
    return np.asarray(local @ record.source_from_local[:3, :3].T + record.center)


def rectangle(record: Record) -> Array:
    """(4, 3) the corners of a surface in its own frame, the lower ones first."""
    x, y = 0.5 * record.size[0], 0.5 * record.size[1]
    return np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])


def _floor(floor: Record, room: CapturedRoom) -> Array:
    corners = placed(floor, floor.corners if len(floor.corners) else rectangle(floor))
    base = corners[0].copy()
    plan = bent((corners - base)[:, [0, 2]], [a - base[[0, 2]] for a in _arcs(room, floor.story)])
    level = float(np.median(corners[:, 1] - base[1]))
    if len(plan) == len(corners):
        return corners
    return np.asarray(np.column_stack([plan[:, 0], np.full(len(plan), level), plan[:, 1]]) + base)


def _around(room: CapturedRoom, rectangle: Array | None) -> Array | None:
    """What the walls enclose where they close, in place of a floor that only tells its sides."""
    notes: list[str] = []
    found = _from_walls(room, notes)
    return rectangle if found is None or notes else found


def _from_walls(room: CapturedRoom, notes: list[str]) -> Array | None:
    """The floor that the bases of the walls enclose, as iOS 16 leaves it to be found."""
    if not room.walls:
        return None
    # Relative to one point, so that sums and differences far from the origin stay exact.
    base = room.walls[0].center
    ends = np.array([_base(wall) - base for wall in room.walls])
    corners = chained((ends @ Z_UP.T)[:, :, :2], notes)
    if corners is None:
        return None
    plan = bent(corners * [1.0, -1.0], [a - base[[0, 2]] for a in _arcs(room, None)])
    level = np.full(len(plan), float(np.median(ends[:, :, 1])))
    return np.column_stack([plan[:, 0], level, plan[:, 1]]) + base


def _base(wall: Record) -> Array:
    """(2, 3) the lower ends of a wall in the source's frame."""
    local = rectangle(wall)[:2]
    if wall.arc:
        local = local.copy()
        local[:, [0, 2]] = wall.arc.ends()
    return placed(wall, local)


def facets(wall: Record) -> Array:
    """(N, 3) the base of a wall in the source's frame: both ends, and between them its facets."""
    if not wall.arc:
        return placed(wall, rectangle(wall)[:2])
    x, z = wall.arc.facets(np.empty((0, 3))).T
    return placed(wall, np.column_stack([x, np.full(len(x), -0.5 * wall.size[1]), z]))


def _arcs(room: CapturedRoom, story: int | None) -> list[Array]:
    """(M, 2) the facets of each curved wall, x and z in the source's frame."""
    arcs = []
    for wall in room.walls:
        if wall.arc and (story is None or wall.story in (None, story)):
            x, z = wall.arc.facets(_openings_in(wall, room)).T
            low = np.full(len(x), -0.5 * wall.size[1])
            arcs.append(placed(wall, np.column_stack([x, low, z]))[:, [0, 2]])
    return arcs


def _openings_in(wall: Record, room: CapturedRoom) -> Array:
    """(K, 3) the openings of a curved wall: their middles in its x and z, and their widths."""
    assert wall.arc is not None
    found = []
    for opening in (*room.doors, *room.windows, *room.openings):
        x, _, z = (opening.center - wall.center) @ wall.source_from_local[:3, :3]
        off = abs(float(np.hypot(x - wall.arc.center[0], z - wall.arc.center[1])) - wall.arc.radius)
        is_near = off < _IN_WALL_M and abs(float(wall.arc.turn(np.array([[x, z]]))[0]) - 0.5) < 0.5
        if opening.parent == wall.id or (opening.parent is None and is_near):
            found.append([x, z, opening.size[0]])
    return np.array(found).reshape(-1, 3)


def _labels_in(outline: Array, story: int | None, room: CapturedRoom) -> list[str]:
    import shapely

    polygon = shapely.make_valid(shapely.Polygon(outline[:, [0, 2]]))
    return [
        section.label
        for section in room.sections
        if (story is None or section.story in (None, story))
        and shapely.contains_xy(polygon, section.center[0], section.center[2])
    ]


def of_story(room: CapturedRoom, story: int | None) -> CapturedRoom:
    """The records that a floor's story may have."""

    def some(records: tuple[Record, ...]) -> tuple[Record, ...]:
        return tuple(r for r in records if story is None or r.story in (None, story))

    return replace(
        room,
        walls=some(room.walls),
        doors=some(room.doors),
        windows=some(room.windows),
        openings=some(room.openings),
        objects=some(room.objects),
    )


def merged(rooms: Sequence[CapturedRoom]) -> CapturedRoom:
    """The records of several scans together, each identifier once."""

    def every(name: str) -> tuple[Record, ...]:
        rows = [row for room in rooms for row in getattr(room, name)]
        return tuple({row.id: row for row in reversed(rows)}.values())[::-1]

    lists = {name: every(name) for name in (*_KINDS, "floors")}
    sections = tuple(section for room in rooms for section in room.sections)
    return CapturedRoom(**lists, sections=sections)


def belonging(records: CapturedRoom, outline: Array, *, is_only: bool) -> CapturedRoom:
    """The walls and openings at or in a floor, and the objects on it.

    Args:
        records: What is near it, or not.
        outline: (N, 3) its corners in the source's frame, metres.
        is_only: Whether the records know no other floor: then its storey needs no telling.
    """
    import shapely

    floor = shapely.make_valid(shapely.Polygon(outline[:, [0, 2]]))
    level = float(np.median(outline[:, 1]))
    around = floor.buffer(_NEAR_FLOOR_M)
    inside = floor.buffer(_OUTSIDE_ONLY_FLOOR_M if is_only else _OUTSIDE_FLOOR_M)
    for area in (around, inside):
        shapely.prepare(area)

    def above(record: Record) -> bool:
        low, high = _ABOVE_FLOOR_LIMITS_M
        return is_only or low < record.center[1] - level < high

    def near(rows: tuple[Record, ...]) -> tuple[Record, ...]:
        return tuple(row for row in rows if above(row) and around.contains(_point(row)))

    # Without other floors, what is outside is reported wall by wall.
    walls = records.walls if is_only else near(records.walls)
    # A stated parent is better evidence than a place near the wall between two rooms.
    known = {wall.id for wall in records.walls}
    own = {wall.id for wall in walls}

    def in_own(rows: tuple[Record, ...]) -> tuple[Record, ...]:
        return tuple(r for r in near(rows) if r.parent not in known or r.parent in own)

    return replace(
        records,
        walls=walls,
        doors=in_own(records.doors),
        windows=in_own(records.windows),
        openings=in_own(records.openings),
        objects=tuple(r for r in records.objects if above(r) and inside.contains(_point(r))),
    )


def left_out(rooms: Sequence[CapturedRoom], kept: CapturedRoom) -> str:
    """How much belongs to no floor that is built, in words; empty where all does.

    Args:
        rooms: All that was captured.
        kept: What is built.
    """
    counts = []
    for name in _KINDS:
        ids = {row.id for room in rooms for row in getattr(room, name)}
        missing = len(ids - {row.id for row in getattr(kept, name)})
        counts += [f"{missing} {name if missing > 1 else name[:-1]}"] if missing else []
    return ", ".join(counts)


def _point(record: Record) -> "Point":
    from shapely import Point

    place = record.center
    if record.arc:
        # The frame of a curved wall may be in the middle of its chord.
        x, z = record.arc.points(np.array([record.arc.start + 0.5 * record.arc.sweep]))[0]
        place = place + record.source_from_local[:3, :3] @ [x, 0.0, z]
    return Point(place[[0, 2]])
