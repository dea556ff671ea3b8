"""Corners and walls of the outline are moved, split and joined; openings stay where they are."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.view.plan.drawing import Drawing, Point, reseated

# How far something is moved at most by snapping, metres.
REACH_M: Final = 0.12
# Walls whose directions differ by less have one direction, degrees.
_SAME_DEG: Final = 6.0
# Walls that are so far off a direction of the room are meant to be oblique, degrees.
OBLIQUE_DEG: Final = 14.0
# Neighbours that meet a wall at less than this keep their place: a step is made beside it.
_STEEP_SINE: Final = 0.3
# Corners that are nearer to each other are one, metres.
_ONE_M: Final = 0.01


def move_corner(plan: Drawing, corner: int, to: Point, *, snap: bool = False) -> Drawing:
    """Put a corner somewhere else."""
    plan.check("corner", corner, len(plan.corners))
    corners = plan.polygon
    corners[corner] = snapped_corner(corners, corner, np.asarray(to)) if snap else to
    return reseated(plan, _points(corners), lambda wall: (wall,))


def move_wall(plan: Drawing, wall: int, by: float, *, snap: bool = False) -> Drawing:
    """Move a wall along its normal, outwards where ``by`` is positive.

    Its neighbours become longer or shorter and keep their directions. One that runs on in nearly
    the same direction keeps its place, and a wall across is made between the two.
    """
    start, end = plan.ends(wall)
    corners, count = plan.polygon, len(plan.corners)
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    normal = np.array([along[1], -along[0]]) * (-1.0 if plan.clockwise else 1.0)
    shift = normal * (snapped_offset(corners, wall, by, normal) if snap else by)
    before, after = corners[wall - 1], corners[(wall + 2) % count]
    first = _slid(start, start - before, along, shift)
    last = _slid(end, end - after, along, shift)
    made: list[Array] = []
    places: dict[int, int] = {}
    for number in range(count):
        places[number] = len(made)
        if number == wall:
            made += [first] if first is not None else [start, start + shift]
            places[number] = len(made) - 1
        elif number == (wall + 1) % count:
            places[number] = len(made) + (last is None)
            made += [last] if last is not None else [end + shift, end]
        else:
            made.append(corners[number])
    return reseated(plan, _points(made), lambda number: (places[number],))


def _slid(corner: Array, neighbour: Array, along: Array, shift: Array) -> Array | None:
    """Where the line of a neighbour meets the moved wall; None where it runs along it."""
    way = neighbour / max(float(np.linalg.norm(neighbour)), 1e-9)
    sine = float(along[0] * way[1] - along[1] * way[0])
    if abs(sine) < _STEEP_SINE:
        return None
    return corner + way * float(along[0] * shift[1] - along[1] * shift[0]) / sine


def split_wall(plan: Drawing, wall: int, at: Point) -> Drawing:
    """Put a corner into a wall, at the point of it that is nearest."""
    start, end = plan.ends(wall)
    share = float((np.asarray(at) - start) @ (end - start)) / float((end - start) @ (end - start))
    if not 0.0 < share < 1.0:
        raise InputError("that point is not beside the wall", remedy="point between its ends")
    made = [*plan.corners]
    made.insert(wall + 1, _point(start + share * (end - start)))
    return reseated(
        plan, made, lambda n: (n,) if n < wall else (n, n + 1) if n == wall else (n + 1,)
    )


def remove_corner(plan: Drawing, corner: int) -> Drawing:
    """Leave a corner out: the walls beside it become one."""
    plan.check("corner", corner, len(plan.corners))
    _check_enough(plan, 1)
    count = len(plan.corners)
    made = [point for number, point in enumerate(plan.corners) if number != corner]

    def became(wall: int) -> tuple[int]:
        if wall in (corner, (corner - 1) % count):
            return ((corner - 1) % (count - 1),) if corner else (count - 2,)
        return (wall - (wall > corner),)

    return reseated(plan, made, became)


def remove_wall(plan: Drawing, wall: int) -> Drawing:
    """Leave a wall out: those beside it meet, or of a step the shorter one moves into line."""
    _check_enough(plan, 1)
    start, end = plan.ends(wall)
    corners, count = plan.polygon, len(plan.corners)
    before, after = start - corners[wall - 1], corners[(wall + 2) % count] - end
    sine = float(before[0] * after[1] - before[1] * after[0])
    sine /= max(float(np.linalg.norm(before) * np.linalg.norm(after)), 1e-9)
    if abs(sine) > _STEEP_SINE:
        off = end - start
        part = float(off[0] * after[1] - off[1] * after[0]) / float(
            before[0] * after[1] - before[1] * after[0]
        )
        moved = move_corner(plan, wall, _point(start + part * before))
        return remove_corner(moved, (wall + 1) % count)
    _check_enough(plan, 2)
    shorter = wall - 1 if np.linalg.norm(before) < np.linalg.norm(after) else wall + 1
    shorter %= count
    a, b = plan.ends(shorter)
    outward = np.array([(b - a)[1], -(b - a)[0]]) / max(float(np.linalg.norm(b - a)), 1e-9)
    outward *= -1.0 if plan.clockwise else 1.0
    step = end - start if shorter == (wall - 1) % count else start - end
    moved = move_wall(plan, shorter, float(step @ outward))
    return _joined(moved)


def _joined(plan: Drawing) -> Drawing:
    """The plan without corners that stand on others or in the middle of straight walls."""
    corner = 0
    while corner < len(plan.corners) and len(plan.corners) > 3:
        points = plan.polygon
        before, here = points[corner - 1], points[corner]
        after = points[(corner + 1) % len(points)]
        span = after - before
        length = max(float(np.linalg.norm(span)), 1e-9)
        off = here - before
        apart = abs(float(span[0] * off[1] - span[1] * off[0])) / length
        if np.linalg.norm(off) < _ONE_M or (apart < _ONE_M and float(off @ (after - here)) > 0):
            plan, corner = remove_corner(plan, corner), 0
        else:
            corner += 1
    return plan


def square(plan: Drawing) -> Drawing:
    """Turn walls that nearly run along or across the room into these directions."""
    corners = plan.polygon
    steps = np.roll(corners, -1, axis=0) - corners
    of_room = room_direction(corners)
    angles = np.degrees(np.arctan2(steps[:, 1], steps[:, 0]))
    turned = np.radians([squared_angle(float(angle), of_room) for angle in angles])
    ways = np.column_stack([np.cos(turned), np.sin(turned)])
    middles = corners + 0.5 * steps
    made = [
        _meeting(middles[i - 1], ways[i - 1], middles[i], ways[i], corners[i])
        for i in range(len(corners))
    ]
    return reseated(plan, _points(made), lambda wall: (wall,))


def _meeting(a: Array, along: Array, b: Array, way: Array, corner: Array) -> Array:
    """Where two lines cross; of such as run alike, the foot of the corner between them."""
    sine = float(along[0] * way[1] - along[1] * way[0])
    if abs(sine) < _STEEP_SINE:
        feet = [p + ((corner - p) @ d) * d for p, d in ((a, along), (b, way))]
        return np.asarray(0.5 * (feet[0] + feet[1]))
    off = b - a
    return np.asarray(a + along * float(off[0] * way[1] - off[1] * way[0]) / sine)


def _check_enough(plan: Drawing, fewer: int) -> None:
    if len(plan.corners) - fewer < 3:
        raise InputError("a room has at least three corners", remedy="move this one instead")


def _point(values: Array) -> Point:
    return float(values[0]), float(values[1])


def _points(values: Array | list[Array]) -> list[Point]:
    return [_point(np.asarray(one)) for one in values]


def room_direction(corners: Array) -> float:
    """The direction along or across which most of the walls run.

    Args:
        corners: (N, 2) metres.

    Returns:
        An angle in [0, 90) degrees.
    """
    steps = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(steps, axis=1)
    angles = np.degrees(np.arctan2(steps[:, 1], steps[:, 0])) % 90.0
    apart = np.abs(_turn(angles[:, None] - angles))
    near = apart < _SAME_DEG
    best = int(np.argmax((near * lengths).sum(axis=1)))
    offsets = _turn(angles - angles[best])
    weights = lengths * near[best]
    return float((angles[best] + (offsets @ weights) / max(float(weights.sum()), 1e-9)) % 90.0)


def snapped_corner(corners: Array, corner: int, to: Array) -> Array:
    """Where a corner is meant to be.

    The walls beside it shall run along or across the room, or at right angles to their other
    neighbours; where both do, it stands where they cross.

    Args:
        corners: (N, 2) as they are.
        corner: Its number.
        to: (2,) where it was dragged to.

    Returns:
        (2,) at most `REACH_M` from there.
    """
    count = len(corners)
    others = np.delete(corners, corner, axis=0)
    of_room = room_direction(others) if count > 3 else room_direction(corners)
    lines = [
        list(_lines(corners[(corner + way) % count], corners[(corner + 2 * way) % count], of_room))
        for way in (-1, 1)
    ]
    crossings = (_crossing(a, b) for a in lines[0] for b in lines[1])
    near = _nearest((point for point in crossings if point is not None), to)
    if near is not None:
        return near
    feet = (start + ((to - start) @ way) * way for side in lines for start, way in side)
    found = _nearest(feet, to)
    return to if found is None else found


def snapped_offset(corners: Array, wall: int, by: float, normal: Array) -> float:
    """How far a wall is meant to be moved: into line with another one that runs as it does.

    Args:
        corners: (N, 2) as they are.
        wall: Its number.
        by: How far it was dragged along its normal, metres.
        normal: (2,) unit.
    """
    start, following = corners[wall], np.roll(corners, -1, axis=0)
    steps = following - corners
    lengths = np.linalg.norm(steps, axis=1)
    across = np.abs(steps @ normal) / np.maximum(lengths, 1e-9)
    offsets = [
        float((corners[i] + following[i] - 2 * start) @ normal / 2)
        for i in np.flatnonzero(across < np.sin(np.radians(_SAME_DEG)))
        if i != wall
    ]
    near = [one for one in offsets if abs(one - by) < REACH_M]
    return min(near, key=lambda one: abs(one - by), default=by)


def _turn(degrees: Array) -> Array:
    """The least turn to a direction of the same pair, from -45 to 45 degrees."""
    return np.asarray((degrees + 45.0) % 90.0 - 45.0)


def squared_angle(angle: float, of_room: float) -> float:
    """A wall's direction, turned into one of the room's where it is nearly that; degrees."""
    off = float(_turn(np.array(angle - of_room)))
    return angle - off if abs(off) < OBLIQUE_DEG else angle


def _lines(start: Array, before: Array, of_room: float) -> Iterator[tuple[Array, Array]]:
    """Lines through a neighbour that a wall may run along: a point and a unit vector each."""
    own = np.degrees(np.arctan2(*(start - before)[::-1]))
    for angle in (of_room, of_room + 90.0, own, own + 90.0):
        yield start, np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])


def _crossing(a: tuple[Array, Array], b: tuple[Array, Array]) -> Array | None:
    sine = float(a[1][0] * b[1][1] - a[1][1] * b[1][0])
    if abs(sine) < 0.2:
        return None
    off = b[0] - a[0]
    return np.asarray(a[0] + a[1] * (off[0] * b[1][1] - off[1] * b[1][0]) / sine)


def _nearest(points: Iterable[Array], to: Array) -> Array | None:
    listed: Sequence[Array] = list(points)
    best = min(listed, key=lambda point: float(np.linalg.norm(point - to)), default=None)
    return None if best is None or np.linalg.norm(best - to) > REACH_M else best
