"""The ceiling of a level scan, or of a part of it: level, or one or two slopes."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.scan.points.surfels import VOXEL_M, Surfels, fit_plane

_MIN_CEILING_M: Final = 1.9
# Least vertical components of normals: of level surfaces, and of slopes.
_LEVEL_COS: Final = float(np.cos(np.deg2rad(8.0)))
_SLOPED_COS: Final = 0.35
_HEIGHT_BIN_M: Final = 0.02
_MIN_AREA_M2: Final = 0.5
# A level that walls exceed by this much is not a ceiling, metres.
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


# Ceilings that are lower in places: soffits, ducts, beams.
#
# The face of a soffit is as long and as high up as the top of a wall, but the room goes on below
# it: there its ceiling is lower than the face. A wall below a soffit ends at that lower ceiling.

_PIXEL_M: Final = 0.05
# A ceiling counts this far from its surfels, for lamps and shadows.
_GAP_M: Final = 0.3
# A soffit is at least as deep; lintels are as deep as a wall.
_DEPTHS_M: Final = (0.2, 0.4)
# Below a ceiling some of the floor is seen, this near and in this part, or it is larger than any
# furniture. Its pieces are told apart by steps of height.
_FLOOR_M: Final = 0.15
_FLOOR_PIXELS: Final = 2
_OVER_FLOOR_SHARE: Final = 0.2
_MIN_CEILING_M2: Final = 0.25
_SURE_CEILING_M2: Final = 4.0
_STEP_M: Final = 0.2


@dataclass(frozen=True, eq=False)
class Ceilings:
    """The heights of ceilings over the plan.

    Attributes:
        low: (2,) the corner of pixel (0, 0), metres.
        height: (X, Y) metres; infinite where none was scanned.
    """

    low: Array
    height: Array

    def above(self, places: Array) -> Array:
        """(N,) the height of the ceiling over places (N, 2); infinite where none was scanned."""
        pixel = np.floor((places - self.low) / _PIXEL_M).astype(int)
        within = ((pixel >= 0) & (pixel < self.height.shape)).all(axis=1)
        found = np.full(len(places), np.inf)
        found[within] = self.height[tuple(pixel[within].T)]
        return found

    def beside(self, places: Array, across: Array) -> tuple[Array, Array]:
        """The highest ceiling within the depth of a soffit, on either side of places.

        Args:
            places: (N, 2) metres.
            across: (N, 2) or (2,) unit, to one of the sides.

        Returns:
            (N,) on that side and (N,) on the other; infinite where none was scanned.
        """
        found = [self.above(places + depth * across) for depth in _DEPTHS_M]
        other = [self.above(places - depth * across) for depth in _DEPTHS_M]
        return np.stack(found).max(axis=0), np.stack(other).max(axis=0)


NO_CEILINGS: Final = Ceilings(np.zeros(2), np.full((1, 1), np.inf))


def ceilings_of(pieces: Surfels) -> Ceilings:
    """The heights of ceilings.

    Args:
        pieces: Surfels of a storey in the level frame.
    """
    from scipy import ndimage

    level = np.abs(pieces.normals[:, 2]) > _LEVEL_COS
    points = pieces.points[level & (pieces.points[:, 2] > _MIN_CEILING_M)]
    if not len(points):
        return NO_CEILINGS
    margin = 2.0 * _GAP_M
    low = points[:, :2].min(axis=0) - margin
    shape = np.ceil((points[:, :2].max(axis=0) + margin - low) / _PIXEL_M).astype(int) + 1
    height = np.zeros(shape)
    pixel = np.floor((points[:, :2] - low) / _PIXEL_M).astype(int)
    # Of a wardrobe's top and the ceiling above it, the ceiling.
    np.maximum.at(height, tuple(pixel.T), points[:, 2])
    floor = pieces.points[level & (np.abs(pieces.points[:, 2]) < _FLOOR_M)]
    pixel = np.floor((floor[:, :2] - low) / _PIXEL_M).astype(int)
    pixel = pixel[((pixel >= 0) & (pixel < shape)).all(axis=1)]
    ground = np.zeros(shape, dtype=np.bool_)
    ground[tuple(pixel.T)] = True
    height[~_over_floor(height, ndimage.binary_dilation(ground, iterations=_FLOOR_PIXELS))] = 0.0
    if not height.any():
        return NO_CEILINGS
    away, nearest = ndimage.distance_transform_edt(height == 0.0, return_indices=True)
    height = np.where(away * _PIXEL_M <= _GAP_M, height[tuple(nearest)], np.inf)
    return Ceilings(low, height)


def _over_floor(height: Array, ground: Mask) -> Mask:
    """(X, Y) level pieces with a floor below: tops of wardrobes have none."""
    from scipy import ndimage

    found = np.zeros(height.shape, dtype=np.bool_)
    steps = np.rint(height / _STEP_M).astype(int)
    for step in np.unique(steps[steps > 0]):
        groups, count = ndimage.label(steps == step, np.ones((3, 3)))
        size = np.bincount(groups.ravel(), minlength=count + 1)
        below = np.bincount(groups[ground], minlength=count + 1)
        area = size * _PIXEL_M**2
        ceiling = (below > _OVER_FLOOR_SHARE * size) & (area > _MIN_CEILING_M2)
        ceiling |= area > _SURE_CEILING_M2
        ceiling[0] = False
        found |= ceiling[groups]
    return found
