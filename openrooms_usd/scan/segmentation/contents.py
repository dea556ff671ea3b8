"""What stands in a room: the surfels that are no floor, wall, ceiling, opening or door leaf."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.surfels import Surfels
from openrooms_usd.scan.results import FoundOpening, FoundRoom

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Surfels this near to a wall are the wall's; those that face it a little farther, too: walls are
# straight, real ones bulge, and scans drift. Metres.
_WALL_M: Final = 0.04
_FACING_WALL_M: Final = 0.1
_FACING_COS: Final = 0.85
# Lower surfels are the floor's; level ones a little higher, too: rugs, and floors that drift bent.
_FLOOR_M: Final = 0.04
_LEVEL_FLOOR_M: Final = 0.1
_LEVEL_COS: Final = 0.85
# Surfels this near to the ceiling are the ceiling's, metres; without one, furniture ends here.
_CEILING_M: Final = 0.12
_TALLEST_M: Final = 2.3
# Frames, sills, leaves and curtains reach this far into the room, and beyond the sides of their
# opening, metres.
_BEFORE_OPENING_M: Final = 0.25
_BESIDE_OPENING_M: Final = 0.15


def contents(pieces: Surfels, rooms: Sequence[FoundRoom]) -> Mask:
    """(M,) whether surfels belong to things that stand in a room.

    Args:
        pieces: In the level frame: floor at z = 0.
        rooms: In the same frame.
    """
    kept = np.zeros(len(pieces), dtype=np.bool_)
    for room in rooms:
        kept |= _inside(pieces, room)
    level = np.abs(pieces.normals[:, 2]) > _LEVEL_COS
    height = pieces.points[:, 2]
    return np.asarray(kept & (height > np.where(level, _LEVEL_FLOOR_M, _FLOOR_M)))


def _inside(pieces: Surfels, room: FoundRoom) -> Mask:
    """(M,) whether surfels lie in a room, off its walls, its ceiling and its openings."""
    import shapely

    corners = room.corners[:, :2]
    kept: Mask = shapely.contains_xy(shapely.Polygon(corners), pieces.points[:, :2])
    top = _TALLEST_M if room.ceiling is None else room.ceiling - _CEILING_M
    kept &= pieces.points[:, 2] < top
    for number, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        kept &= ~_of_wall(pieces, start, end, [o for o in room.openings if o.wall == number])
    return kept


def _of_wall(pieces: Surfels, start: Array, end: Array, openings: Sequence[FoundOpening]) -> Mask:
    """(M,) whether surfels are a wall's, or those of its openings."""
    length = float(np.linalg.norm(end - start))
    along = (end - start) / max(length, 1e-9)
    inward = np.array([-along[1], along[0]])
    station = (pieces.points[:, :2] - start) @ along
    depth = (pieces.points[:, :2] - start) @ inward
    facing = np.abs(pieces.normals[:, :2] @ inward) > _FACING_COS
    walled = (station > 0.0) & (station < length)
    walled &= depth < np.where(facing, _FACING_WALL_M, _WALL_M)
    for opening in openings:
        across = (opening.corners[:, :2] - start) @ along
        low, high = opening.corners[:, 2].min(), opening.corners[:, 2].max()
        before = (station > across.min() - _BESIDE_OPENING_M) & (depth < _BEFORE_OPENING_M)
        before &= (station < across.max() + _BESIDE_OPENING_M) & (pieces.points[:, 2] > low)
        walled |= before & (pieces.points[:, 2] < high + _BESIDE_OPENING_M)
    return np.asarray(walled)
