"""Vertical faces that are not walls: the room is seen to continue beyond them.

The face of a soffit hangs as high as the top of a wall, but below it the room goes on to a wall
farther out, or under a lower ceiling. An open door's leaf and a wardrobe stand as a wall does, but
above them the wall behind is seen.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.scan.points.surfels import Surfels
from openrooms_usd.scan.rooms.ceilings import Ceilings
from openrooms_usd.scan.rooms.directions import UPRIGHT_SINE

_PIXEL_M: Final = 0.05
_COURSE_M: Final = 0.1  # height of a bin
_SIDES: Final = (1.0, -1.0)
# Heights at which walls are seen below soffits.
_BODY_M: Final = (0.3, 2.1)
# What has a wall in this part of them is a wall up to its top; what has less hangs.
_WALL_SHARE: Final = 0.5
_NOTHING_SHARE: Final = 0.15
_LEAST_HANGING_M: Final = 1.9
# Where walls behind faces are looked for, metres: beyond the face's own surfels.
_BEHIND_M: Final = (0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6)
# The underside of a soffit is seen this near its face, and lower by this, metres.
_UNDERSIDE_M: Final = 0.1
_LOWER_M: Final = 0.03
# The wall below a soffit does not go on up behind it, at the heights around a place of its face.
_BAND_M: Final = 0.15
# The room is on the side where its ceiling is seen at some of these distances, metres.
_ROOM_M: Final = (0.5, 0.7, 0.9)
# Lintels are shorter than beams that span a room, and than soffits before a wall.
_MIN_BEAM_M: Final = 2.0
_MIN_SOFFIT_M: Final = 1.2
# Leaves and wardrobes are at least as high; lower things are not evidence of walls anyway.
_LEAST_STANDING_M: Final = 1.5
# They end below the ceiling by at least this; the wall is seen in so much of the heights above.
_MIN_ABOVE_M: Final = 0.25
_SEEN_ABOVE_SHARE: Final = 0.5


@dataclass(frozen=True, eq=False)
class _Columns:
    """Which heights of the plan's pixels have vertical surfels, there or one pixel beside.

    Attributes:
        low: (2,) the corner of pixel (0, 0), metres.
        total: (X, Y, C + 1) number of filled bins below each.
    """

    low: Array
    total: NDArray[np.int16]

    def shares(self, places: Array, low: Array | float, high: Array | float) -> Array:
        """(N,) the part of the bins between two heights that is filled; 0 where there are none."""
        pixel = np.floor((places - self.low) / _PIXEL_M).astype(int)
        pixel = np.clip(pixel, 0, np.array(self.total.shape[:2]) - 1)
        x, y = pixel.T
        a, b = (
            np.clip(
                np.rint(np.broadcast_to(height, len(places)) / _COURSE_M).astype(int),
                0,
                self.total.shape[2] - 1,
            )
            for height in (low, high)
        )
        filled = self.total[x, y, b] - self.total[x, y, a]
        return np.asarray(filled / np.maximum(b - a, 1) * (b > a))

    def tops(self, places: Array) -> Array:
        """(N,) the height up to which something stands at places, metres."""
        x, y = np.floor((places - self.low) / _PIXEL_M).astype(int).T
        whole = self.total[x, y]
        return np.asarray((whole < whole[:, -1:]).sum(axis=1) * _COURSE_M)


def no_walls(pieces: Surfels, ceilings: Ceilings) -> tuple[Mask, Mask]:
    """(M,) surfels of faces that hang, and (M,) of faces that stand before a wall.

    Args:
        pieces: Surfels of a storey in the level frame.
        ceilings: Its ceilings.
    """
    upright = np.abs(pieces.normals[:, 2]) < UPRIGHT_SINE
    rows = np.flatnonzero(upright & (pieces.points[:, 2] > 0.0))
    hanging, standing = (np.zeros(len(pieces), dtype=np.bool_) for _ in range(2))
    if not len(rows):
        return hanging, standing
    points, across = pieces.points[rows], pieces.normals[rows, :2]
    across = across / np.maximum(np.linalg.norm(across, axis=1), 1e-9)[:, None]
    columns = _columns(points)
    hanging[rows] = _hangs(points, across, columns, ceilings)
    left = rows[~hanging[rows]]
    if len(left):
        below, across = pieces.points[left], across[~hanging[rows]]
        standing[left] = _stands(below, across, _columns(below), ceilings)
    return hanging, standing


def _columns(points: Array) -> _Columns:
    margin = max(_BEHIND_M) + 2.0 * _PIXEL_M
    low = points[:, :2].min(axis=0) - margin
    shape = np.ceil((points[:, :2].max(axis=0) + margin - low) / _PIXEL_M).astype(int) + 1
    courses = int(points[:, 2].max() / _COURSE_M) + 1
    filled = np.zeros((*shape, courses), dtype=np.bool_)
    x, y = np.floor((points[:, :2] - low) / _PIXEL_M).astype(int).T
    course = (points[:, 2] / _COURSE_M).astype(int)
    # A wall that leans or wavers is a pixel beside itself.
    for right in (-1, 0, 1):
        for up in (-1, 0, 1):
            filled[x + right, y + up, course] = True
    total = np.cumsum(filled, axis=2, dtype=np.int16)
    return _Columns(low, np.pad(total, ((0, 0), (0, 0), (1, 0))))


def _hangs(points: Array, across: Array, columns: _Columns, ceilings: Ceilings) -> Mask:
    """Faces under which the room goes on."""
    plan, height = points[:, :2], points[:, 2]
    body = columns.shares(plan, *_BODY_M)
    lower = height - _LOWER_M
    found = (np.min(ceilings.beside(plan, across), axis=0) < lower) & (body < _WALL_SHARE)
    free = np.flatnonzero((height > _LEAST_HANGING_M) & (body < _NOTHING_SHARE))
    plan, height, lower, across = plan[free], height[free], lower[free], across[free]
    underside, walled = (np.zeros(len(free), dtype=np.bool_) for _ in range(2))
    for side in _SIDES:
        away = side * across
        inner = _roofed(plan, -away, lower, ceilings)
        outer = inner & ~_roofed(plan, away, lower, ceilings)
        # Beyond a beam the room goes on under its ceiling, beyond the lintel of a gate it does not.
        onward = _roofed(plan, away, np.zeros(len(plan)), ceilings)
        underside |= inner & onward & (ceilings.above(plan + _UNDERSIDE_M * away) < lower)
        for depth in _BEHIND_M:
            behind = plan + depth * away
            wall = outer & (columns.shares(behind, *_BODY_M) > _WALL_SHARE)
            wall &= columns.shares(behind, height - _BAND_M, height + _BAND_M) < _WALL_SHARE
            walled |= wall
    for rule, length in ((underside, _MIN_BEAM_M), (walled, _MIN_SOFFIT_M)):
        rows = free[rule]
        found[rows] |= _extents(points[rows, :2]) > length
    return np.asarray(found & (points[:, 2] > _LEAST_HANGING_M))


def _roofed(plan: Array, away: Array, height: Array, ceilings: Ceilings) -> Mask:
    """(N,) whether a ceiling above a height was seen to one side of places."""
    found = np.zeros(len(plan), dtype=np.bool_)
    for distance in _ROOM_M:
        above = ceilings.above(plan + distance * away)
        found |= np.isfinite(above) & (above > height)
    return found


def _extents(plan: Array) -> Array:
    """(N,) the extent of the connected face of each place, metres."""
    from scipy import ndimage

    if not len(plan):
        return np.zeros(0)
    pixel = np.floor((plan - plan.min(axis=0)) / _PIXEL_M).astype(int) + 1
    filled = np.zeros(pixel.max(axis=0) + 2, dtype=np.bool_)
    filled[tuple(pixel.T)] = True
    joined = ndimage.binary_dilation(filled, np.ones((3, 3), dtype=np.bool_))
    groups, _ = ndimage.label(joined, np.ones((3, 3)))
    places = [place for place in ndimage.find_objects(groups) if place is not None]
    spans = [[rows.stop - rows.start for rows in place] for place in places]
    extents = np.array([0.0, *(_PIXEL_M * max(span) for span in spans)])
    return np.asarray(extents[groups[tuple(pixel.T)]])


def _stands(points: Array, across: Array, columns: _Columns, ceilings: Ceilings) -> Mask:
    """Faces above which a wall is seen behind them."""
    plan = points[:, :2]
    top = columns.tops(plan)
    room = np.min(ceilings.beside(plan, across), axis=0)
    room = np.minimum(room, _COURSE_M * (columns.total.shape[2] - 1))
    found = np.zeros(len(plan), dtype=np.bool_)
    rows = np.flatnonzero((top > _LEAST_STANDING_M) & (room - top > _MIN_ABOVE_M))
    plan, across, top, room = plan[rows], across[rows], top[rows], room[rows]
    for side in _SIDES:
        away = side * across
        outer = _roofed(plan, -away, top, ceilings) & ~_roofed(plan, away, top, ceilings)
        for depth in _BEHIND_M:
            seen = columns.shares(plan + depth * away, top + _COURSE_M, room)
            found[rows] |= outer & (seen > _SEEN_ABOVE_SHARE)
    return found
