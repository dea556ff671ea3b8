"""Where a person probably means to put a corner or a wall: along the directions of the room."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# How far something is moved at most by snapping, metres.
REACH_M: Final = 0.12
# Walls whose directions differ by less have one direction, degrees.
_SAME_DEG: Final = 6.0
# Walls that are so far off a direction of the room are meant to be oblique, degrees.
OBLIQUE_DEG: Final = 14.0


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
