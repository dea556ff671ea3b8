"""The ceiling of a level scan, or of a part of it: level, or one or two slopes."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.points.planes import fit_plane
from openrooms_usd.scan.points.surfels import VOXEL_M, Surfels

_MIN_CEILING_M: Final = 1.9
# Least vertical components of normals: of level surfaces, and of slopes.
_LEVEL_COS: Final = float(np.cos(np.deg2rad(8.0)))
_SLOPED_COS: Final = 0.35
_HEIGHT_BIN_M: Final = 0.02
_MIN_AREA_M2: Final = 0.5
# A level that walls exceed by this much is no ceiling, metres.
_WALL_ABOVE_CEILING_M: Final = 0.12
# Least height of slopes, tolerances of their inliers and least area of each. A shed roof has one
# slope, a gable roof two.
_MIN_EAVES_M: Final = 1.0
_ON_SLOPE_M: Final = 0.06
_ON_SLOPE_COS: Final = 0.97
_MIN_SLOPE_AREA_M2: Final = 1.5
_MAX_SLOPES: Final = 2
_MAX_SLOPE_DEG: Final = 70.0


def ceiling_height(pieces: Surfels) -> float | None:
    """The height of a level ceiling.

    Args:
        pieces: Surfels of a room, in the level frame.

    Returns:
        Metres above the floor; None where no ceiling was scanned, or where most of it slopes.
    """
    high = pieces.take(pieces.points[:, 2] > _MIN_CEILING_M)
    steep = np.abs(high.normals[:, 2])
    flat = high.points[steep > _LEVEL_COS, 2]
    least = _MIN_AREA_M2 / VOXEL_M**2
    if len(flat) < least:
        return None
    height, count = _peak(flat)
    sloped = int(((steep < _LEVEL_COS) & (steep > _SLOPED_COS)).sum())
    above = high.points[
        (steep < _SLOPED_COS) & (high.points[:, 2] > height + _WALL_ABOVE_CEILING_M)
    ]
    upright = high.points[steep < _SLOPED_COS]
    if count < least or sloped > count or len(above) > 0.15 * len(upright):
        return None
    return height


def ceiling_slopes(pieces: Surfels) -> tuple[tuple[Array, Array], ...]:
    """The planes of a sloping ceiling, the largest first.

    Args:
        pieces: Surfels of a room, in the level frame.

    Returns:
        At most two, each with its unit normal (3,) into the room and a point (3,) of it.
    """
    steep = np.abs(pieces.normals[:, 2])
    left = pieces.take(
        (steep < _LEVEL_COS) & (steep > _SLOPED_COS) & (pieces.points[:, 2] > _MIN_EAVES_M)
    )
    found: list[tuple[Array, Array]] = []
    while len(found) < _MAX_SLOPES:
        plane = fit_plane(left.points, np.array([0.0, 0.0, 1.0]), _ON_SLOPE_M, _MAX_SLOPE_DEG)
        if plane is None:
            break
        on = np.abs(plane.heights(left.points)) < _ON_SLOPE_M
        alike = on & (np.abs(left.normals @ plane.normal) > _ON_SLOPE_COS)
        if alike.sum() * VOXEL_M**2 < _MIN_SLOPE_AREA_M2:
            break
        found.append((-plane.normal, plane.point))
        left = left.take(~on)
    return tuple(found)


def _peak(heights: Array) -> tuple[float, int]:
    """The mode of heights in a window of five centimetres, and its count."""
    counts = np.bincount((heights / _HEIGHT_BIN_M).astype(int))
    density = np.convolve(np.append(counts, np.zeros(5)), np.ones(5), "same")
    peak = (int(density.argmax()) + 0.5) * _HEIGHT_BIN_M
    near = heights[np.abs(heights - peak) < 2.5 * _HEIGHT_BIN_M]
    return float(np.median(near)), len(near)
