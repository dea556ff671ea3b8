"""Rooms of a scan that stand wall to wall, as one: the walls between them, and what is in these."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.joining import WallBetween, joined_floors, walls_between
from openrooms_usd.geometry.polygons import counter_clockwise, defect
from openrooms_usd.scan.results import FoundOpening, FoundRoom

# Jogs of the outline up to this are two rooms' inexact measures of one line, metres.
_MAX_JOG_M: Final = 0.03
# Ends of an opening that its two sides show farther apart are where the inner one is: beyond it the
# wall is there on one side. By less the sides of a scan drift apart, metres.
_MAX_DRIFT_M: Final = 0.1


@dataclass(frozen=True, eq=False)
class FlatOpening:
    """An opening of a flat.

    Attributes:
        opening: As it was found.
        between: The number of the wall between rooms that it is in; None in an outer wall.
    """

    opening: FoundOpening
    between: int | None


@dataclass(frozen=True, eq=False)
class Flat:
    """Several rooms as one.

    Attributes:
        corners: (N, 2) the outline of them all, in the plan.
        members: Their numbers.
        walls: Between them.
        openings: Of all walls; what was found from both sides of one is there once.
        notes: What was left out, one sentence each.
    """

    corners: Array
    members: tuple[int, ...]
    walls: tuple[WallBetween, ...]
    openings: tuple[FlatOpening, ...]
    notes: tuple[str, ...]


def flat_of(rooms: Sequence[FoundRoom]) -> Flat | None:
    """The first room with those that stand wall to wall, or None where none does.

    Args:
        rooms: In the level frame.
    """
    found = joined_floors([room.corners[:, :2] for room in rooms], 0) if rooms else None
    if found is None:
        return None
    corners, members = found
    own = [rooms[number] for number in members]
    unseen = {(index, wall) for index, room in enumerate(own) for wall in room.guessed}
    walls = walls_between([room.corners[:, :2] for room in own], unseen)
    openings, notes = _openings(own, walls)
    away = [
        f"room {number} ({abs(signed_area(room.corners[:, :2])):.1f} m2)"
        for number, room in enumerate(rooms)
        if number not in members
    ]
    if away:
        notes.append(f"left out, because they touch no other room: {', '.join(away)}")
    return Flat(_without_jogs(corners), tuple(members), walls, tuple(openings), tuple(notes))


def _without_jogs(corners: Array) -> Array:
    """The outline in as few corners as it takes."""
    import shapely

    ring = shapely.get_coordinates(shapely.Polygon(corners).simplify(_MAX_JOG_M))[:-1]
    plain, _ = counter_clockwise(ring if defect(ring) is None else corners)
    return plain


def _openings(
    rooms: Sequence[FoundRoom], walls: Sequence[WallBetween]
) -> tuple[list[FlatOpening], list[str]]:
    """The openings of all rooms, and what was left out."""
    found = [(i, o, _wall_of(i, o, walls)) for i, r in enumerate(rooms) for o in r.openings]
    doubted = [(i, o, _wall_of(i, o, walls)) for i, r in enumerate(rooms) for o in r.doubtful]
    kept: list[FlatOpening] = []
    one_sided = 0
    # The surest first: its twin from the other side is dropped.
    for room, opening, wall in sorted(found, key=lambda row: -row[1].confidence):
        if wall is None:
            kept.append(FlatOpening(opening, None))
            continue
        if any(k.between == wall and _overlap(opening, k.opening, walls[wall]) for k in kept):
            continue
        behind = [o for i, o, w in (*found, *doubted) if w == wall and i != room]
        if opening.type == "window" and not any(_overlap(opening, o, walls[wall]) for o in behind):
            one_sided += 1
            continue
        twins = [o for i, o, w in found if w == wall and i != room and o.type == opening.type]
        kept.append(FlatOpening(_through(opening, twins, walls[wall]), wall))
    if not one_sided:
        return kept, []
    what = "window" if one_sided == 1 else "windows"
    return kept, [f"left out {one_sided} {what} of inner walls that only one side shows"]


def _wall_of(room: int, opening: FoundOpening, walls: Sequence[WallBetween]) -> int | None:
    """The wall between rooms that an opening of a room is in."""
    middle = opening.corners[:, :2].mean(axis=0)[None]
    for number, wall in enumerate(walls):
        station = float(wall.place(middle)[0][0])
        if (room, opening.wall) in wall.sides and 0.0 < station < wall.length:
            return number
    return None


def _overlap(one: FoundOpening, other: FoundOpening, wall: WallBetween) -> bool:
    """Whether two openings of a wall are in one place."""
    a, b = (np.sort(wall.place(opening.corners[:2, :2])[0]) for opening in (one, other))
    return bool(min(a[1], b[1]) > max(a[0], b[0]))


def _through(one: FoundOpening, twins: Sequence[FoundOpening], wall: WallBetween) -> FoundOpening:
    """An opening of a wall where both its sides are open."""
    ends = wall.place(one.corners[:2, :2])[0]
    low, high = np.sort(ends)
    inner = np.array([low, high])
    for twin in twins:
        if _overlap(one, twin, wall):
            a, b = np.sort(wall.place(twin.corners[:2, :2])[0])
            inner = np.array([max(inner[0], a), min(inner[1], b)])
    shown = np.where(np.abs(inner - (low, high)) > _MAX_DRIFT_M, inner, (low, high))
    if np.array_equal(shown, (low, high)):
        return one
    left, right = (np.sort(shown)[:: 1 if ends[0] < ends[1] else -1] - ends[0]) / np.diff(ends)
    bottom, top = one.corners[1] - one.corners[0], one.corners[2] - one.corners[3]
    corners = [
        one.corners[0] + left * bottom,
        one.corners[0] + right * bottom,
        one.corners[3] + right * top,
        one.corners[3] + left * top,
    ]
    return replace(one, corners=np.array(corners))
