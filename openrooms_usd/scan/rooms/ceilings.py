"""The ceiling of a level scan, or of a part of it: level, or one or two slopes."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.planes import fit_plane
from openrooms_usd.scan.points.surfels import VOXEL, Surfels

Array = NDArray[np.float64]

_LOWEST: Final = 1.9  # metres
# Normals nearer to the vertical are of level surfaces; up to the other, of slopes; as cosines.
_LEVEL: Final = float(np.cos(np.deg2rad(8.0)))
_SLOPED: Final = 0.35
_BIN: Final = 0.02
_LEAST_AREA: Final = 0.5  # square metres
# Walls do not go on for this much above the ceiling, metres.
_ABOVE: Final = 0.12
# Slopes begin at this height; their pieces lie this near to them, metres, and face as they do, as
# a cosine; each has this area, square metres. A shed roof has one, a gable roof two.
_EAVES: Final = 1.0
_NEAR: Final = 0.06
_ALIKE: Final = 0.97
_LEAST_SLOPE: Final = 1.5
_SLOPES: Final = 2
_STEEPEST: Final = 70.0


def ceiling_height(pieces: Surfels) -> float | None:
    """How high the ceiling is.

    Args:
        pieces: Of a room, in the level frame.

    Returns:
        Metres above the floor; None where no ceiling was seen, or where most of it slopes.
    """
    high = pieces.take(pieces.points[:, 2] > _LOWEST)
    steep = np.abs(high.normals[:, 2])
    flat = high.points[steep > _LEVEL, 2]
    least = _LEAST_AREA / VOXEL**2
    if len(flat) < least:
        return None
    height, count = _peak(flat)
    sloped = int(((steep < _LEVEL) & (steep > _SLOPED)).sum())
    above = high.points[(steep < _SLOPED) & (high.points[:, 2] > height + _ABOVE)]
    upright = high.points[steep < _SLOPED]
    if count < least or sloped > count or len(above) > 0.15 * len(upright):
        return None
    return height


def ceiling_slopes(pieces: Surfels) -> tuple[tuple[Array, Array], ...]:
    """The planes of a sloping ceiling, the largest first.

    Args:
        pieces: Of a room, in the level frame.

    Returns:
        At most two, each with its unit normal (3,) into the room and a point (3,) of it.
    """
    steep = np.abs(pieces.normals[:, 2])
    left = pieces.take((steep < _LEVEL) & (steep > _SLOPED) & (pieces.points[:, 2] > _EAVES))
    found: list[tuple[Array, Array]] = []
    while len(found) < _SLOPES:
        plane = fit_plane(left.points, np.array([0.0, 0.0, 1.0]), _NEAR, _STEEPEST)
        if plane is None:
            break
        on = np.abs(plane.heights(left.points)) < _NEAR
        alike = on & (np.abs(left.normals @ plane.normal) > _ALIKE)
        if alike.sum() * VOXEL**2 < _LEAST_SLOPE:
            break
        found.append((-plane.normal, plane.point))
        left = left.take(~on)
    return tuple(found)


def _peak(heights: Array) -> tuple[float, int]:
    """The height where most pieces lie, within five centimetres, and their number."""
    counts = np.bincount((heights / _BIN).astype(int))
    density = np.convolve(np.append(counts, np.zeros(5)), np.ones(5), "same")
    peak = (int(density.argmax()) + 0.5) * _BIN
    near = heights[np.abs(heights - peak) < 2.5 * _BIN]
    return float(np.median(near)), len(near)
