"""Snaps an object that was placed roughly: along walls, and flush to them.

Sides that are nearly parallel to the nearest wall become parallel to it, and sides that are near a
wall, or beyond it, come flush to it. What hangs on walls hangs on the nearest one.
"""

from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.steps.alignment.surroundings import RoomGeometry

# Nearer than this a side comes to its wall, and turned by less it turns with it.
REACH_M: Final = 0.15
TURN_DEG: Final = 8.0
# What is farther behind a wall was not put there by mistake.
_BEHIND_M: Final = 1.0


class PlanPoint(NamedTuple):
    """A place in the plan.

    Attributes:
        x: Metres.
        y: Metres.
        yaw: Degrees, counter-clockwise from above.
    """

    x: float
    y: float
    yaw: float


def snapped(room: RoomGeometry, spot: PlanPoint, low: Array, high: Array) -> PlanPoint:
    """The place of a box that stands on the floor.

    Args:
        room: What it stands in.
        spot: Where its origin was put.
        low: (2,) its least x and y in its own frame, metres.
        high: (2,) its greatest.
    """
    faces = room.faces
    if not len(faces):
        return spot
    yaw = _parallel(faces, spot)
    corners = _corners(low, high) @ in_plan(np.radians(yaw)).T
    place = np.array([spot.x, spot.y])
    # A box in a corner comes to both walls; the second pass sees where the first has put it.
    for start, end in (*faces, *faces):
        place = place + _to_wall(start, end, place, corners)
    return PlanPoint(float(place[0]), float(place[1]), yaw)


def hung(room: RoomGeometry, spot: PlanPoint, low: Array, high: Array) -> PlanPoint:
    """The place of a box that hangs with its back on the nearest wall."""
    if not len(room.faces):
        return spot
    width, depth = (high - low).tolist()
    found = room.hang(spot.x, spot.y, width, depth)
    # The origin of what hangs need not be the middle of its box.
    off = in_plan(np.radians(found.yaw)) @ (0.5 * (low + high))
    return PlanPoint(found.x - float(off[0]), found.y - float(off[1]), found.yaw)


def _corners(low: Array, high: Array) -> Array:
    return np.array([(x, y) for x in (low[0], high[0]) for y in (low[1], high[1])])


def _parallel(faces: Array, spot: PlanPoint) -> float:
    """The heading, along the nearest wall or square to it where it nearly is."""
    starts, steps = faces[:, 0], faces[:, 1] - faces[:, 0]
    lengths = np.linalg.norm(steps, axis=1)
    offsets = np.array([spot.x, spot.y]) - starts
    along = np.clip((offsets * steps).sum(axis=1) / lengths**2, 0.0, 1.0)
    gaps = np.linalg.norm(offsets - along[:, None] * steps, axis=1)
    x, y = steps[int(np.argmin(gaps))].tolist()
    off = (spot.yaw - float(np.degrees(np.arctan2(y, x))) + 45.0) % 90.0 - 45.0
    return round(spot.yaw - off, 6) if abs(off) <= TURN_DEG else spot.yaw


def _to_wall(start: Array, end: Array, place: Array, corners: Array) -> Array:
    """(2,) the step that brings a box flush to a wall; none where the wall is elsewhere."""
    step = end - start
    length = float(np.linalg.norm(step))
    ahead = step / length
    inward = np.array([-ahead[1], ahead[0]])
    reached = (place + corners - start) @ ahead
    gap = float(((place + corners - start) @ inward).min())
    beside = reached.max() <= 0.0 or reached.min() >= length
    behind = float((place - start) @ inward) < -_BEHIND_M
    if beside or behind or gap > REACH_M:
        return np.zeros(2)
    return np.asarray(-gap * inward)
