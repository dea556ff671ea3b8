"""Which records of a RoomPlan export belong to a floor, and what is left out with the others."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from orusd_scans.roomplan.records import CapturedRoom, Record

if TYPE_CHECKING:
    from shapely import Point

Array = NDArray[np.float64]

# Largest distance of a floor's walls and openings from it, metres; of objects where there are other
# floors, and of objects where there are none.
_NEAR_FLOOR_M: Final = 0.5
_OUTSIDE_FLOOR_M: Final = 0.1
_OUTSIDE_ONLY_FLOOR_M: Final = 0.5
# Heights above a floor between which the centres of its records are, metres.
_ABOVE_FLOOR_LIMITS_M: Final = (-0.5, 4.0)
_KINDS: Final = ("walls", "doors", "windows", "openings", "objects")


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

    # Without other floors, what is outside is told wall by wall.
    walls = records.walls if is_only else near(records.walls)
    # A parent that is told says more than a place near the wall between two rooms.
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
