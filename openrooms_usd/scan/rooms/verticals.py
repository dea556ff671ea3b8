"""Which way is up in a scan: what speaks for every axis, whatever its unit.

A room that lies on its side still has flat, square surfaces, so no single sign settles it. Several
signs are weighed, as logarithms of odds. Level surfaces are large, and the floor is the largest.
Things stand upright at any azimuth, so odd surfaces are square to the vertical. The distance from
floor to ceiling is that of a room. Furniture stands on the floor, away from the walls, and not
under the ceiling. The weights are those of a logistic regression over real and simulated scans,
turned every way.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import VOXEL_M, Surfels, surfels
from openrooms_usd.scan.points.thinning import evened

# Surfels that a scan must have to be judged.
_FEWEST_PIECES: Final = 1000
# Modes of normals: within this of each other, apart by this, with this part of all, degrees.
_MODE_DEG: Final = 4.0
_APART_DEG: Final = 15.0
_MODE_SHARE: Final = 0.01
_MOST_MODES: Final = 4
_RIGHT_ANGLE_COS: Final = 0.15
# Level and upright surfaces, those that belong to no mode, and the narrow band, degrees.
_LEVEL_DEG: Final = 10.0
_ODD_DEG: Final = 12.0
_BAND_DEG: Final = 4.0
# A level counts from this part of the largest one; an end is open when this part of the walls
# goes on beyond the last level.
_LEVEL_SHARE: Final = 0.2
_OPEN_SHARE: Final = 0.25
# Tops are so far from floor and ceiling, in voxels; the lower ones are at this percentile of all,
# which are at least this part of the surfels.
_OFF_ENDS: Final = 3.0
_LOWER_TOPS: Final = 25.0
_TOPS_SHARE: Final = 0.004
# A column of the plan is a wall's when so many tenths of the height are occupied.
_TENTHS: Final = 10
_WALL_TENTHS: Final = 6
_COLUMN: Final = 2.0 * VOXEL_M
_NEAR_WALL_COLUMNS: Final = 2
# Weights of the evidence, natural logarithms of odds.
_ODD, _LEVEL, _LARGEST, _SQUARE = 1.35, 1.15, 1.65, 0.8
_THINGS, _TOPS, _LID, _FLOOR, _BEYOND = 1.3, 0.65, 0.35, 0.25, 0.8
_MOST_RATIO: Final = 1.2
_LABELLED: Final = 6.0
# NYU40, and the least part of a class that must be level to be believed.
_FLOOR_LABEL, _CEILING_LABEL = 2, 22
_LABEL_SHARE: Final = 0.7


@dataclass(frozen=True, eq=False)
class Vertical:
    """A direction that may be up.

    Attributes:
        axis: (3,) unit.
        line: What speaks for this axis, either way, without its height: log odds but for a
            constant of all.
        upwards: What speaks for this and against the opposite direction, log odds.
        height: From the floor to the ceiling, in the scan's unit; None where either is not seen.
        extent: (2,) of the scan along the axis, and the larger one across, in the scan's unit.
        tops: Height of the lower level surfaces away from the walls above the floor, in the scan's
            unit; None where there are hardly any.
    """

    axis: Array
    line: float
    upwards: float
    height: float | None
    extent: tuple[float, float]
    tops: float | None = None

    def reversed(self) -> "Vertical":
        """The opposite direction."""
        return replace(self, axis=-self.axis, upwards=-self.upwards)


def verticals(cloud: Cloud) -> tuple[Vertical, ...]:
    """The axes that may be vertical, the likeliest first; none where there is hardly any surface.

    Args:
        cloud: Finite points in any unit. Labels (NYU40) help where they are given.
    """
    near, scale = _in_voxels(cloud)
    pieces = None if near is None else surfels(near)
    if pieces is None or len(pieces) < _FEWEST_PIECES:
        return ()
    axes = _candidates(pieces.normals)
    odd = np.logical_and.reduce([np.abs(pieces.normals @ axis) < _cos(_ODD_DEG) for axis in axes])
    found = [_weighed(pieces, axis, odd, scale) for axis in axes]
    return tuple(sorted((one for one in found if one), key=lambda one: -one.line))


def _cos(degrees: float) -> float:
    return float(np.cos(np.deg2rad(degrees)))


def _sin(degrees: float) -> float:
    return float(np.sin(np.deg2rad(degrees)))


def _in_voxels(cloud: Cloud) -> tuple[Cloud | None, float]:
    """The points scaled so that they make about the wanted number of surfels, and the factor."""
    if len(cloud) < _FEWEST_PIECES or not np.ptp(cloud.points, axis=0).any():
        return None, 1.0
    rows, voxel = evened(cloud)
    some, scale = cloud.points[rows], VOXEL_M / voxel
    label = None if cloud.label is None else cloud.label[rows]
    return Cloud((some - np.median(some, axis=0)) * scale, label=label), scale


def _candidates(normals: Array) -> list[Array]:
    """Modes of the normals, and what is square to two of them; each axis the positive way."""
    some = normals[:: max(1, len(normals) // 1500)]
    votes = (np.abs(some @ some.T) > _cos(_MODE_DEG)).sum(axis=1).astype(float)
    modes: list[Array] = []
    while len(modes) < _MOST_MODES and votes.max() >= _MODE_SHARE * len(some):
        axis = some[votes.argmax()]
        for width in (2.0 * _MODE_DEG, _MODE_DEG, _MODE_DEG):
            near = normals[np.abs(normals @ axis) > _cos(width)]
            axis = (near * np.sign(near @ axis)[:, None]).mean(axis=0)
            axis = axis / np.linalg.norm(axis)
        modes.append(axis)
        votes[np.abs(some @ axis) > _cos(_APART_DEG)] = 0.0
    axes = list(modes)
    for number, first in enumerate(modes):
        for second in modes[:number]:
            third = np.cross(first, second)
            third /= np.linalg.norm(third)
            square = abs(first @ second) < _RIGHT_ANGLE_COS
            if square and all(abs(third @ axis) < _cos(_APART_DEG) for axis in axes):
                axes.append(third)
    return [axis * np.sign(axis[np.abs(axis).argmax()]) for axis in axes]


def _weighed(pieces: Surfels, axis: Array, odd: Mask, scale: float) -> Vertical | None:
    slope, heights = np.abs(pieces.normals @ axis), pieces.points @ axis
    level, wall = slope > _cos(_LEVEL_DEG), slope < _sin(_LEVEL_DEG)
    band = ((odd & (slope < _sin(_BAND_DEG))).sum() / _sin(_BAND_DEG) + 20) / (odd.sum() + 20)
    ends = _ends(heights[level])
    if ends is None:
        return None
    (bottom, top), areas = ends
    walls = heights[wall] if wall.any() else heights
    below, above = float((walls < bottom - 0.15).mean()), float((walls > top + 0.15).mean())
    closed = below < _OPEN_SHARE and above < _OPEN_SHARE
    shares = areas / len(pieces)
    line = (
        _ODD * np.log(band)
        + _LEVEL * np.log(level.mean() + 0.03)
        + _LARGEST * np.log(shares.max() + 0.02)
        - _SQUARE * np.log(1.05 - level.mean() - wall.mean())
    )
    low, high = np.percentile(walls, (2.0, 98.0))
    span = (
        min(bottom, low) if below > _OPEN_SHARE else bottom,
        (max(top, high) if above > _OPEN_SHARE else top),
    )
    stand, tops = _standing(pieces.points, axis, heights, level, span)
    upwards = (
        stand
        + _LID * (float(above > _OPEN_SHARE) - float(below > _OPEN_SHARE))
        + _FLOOR * np.log((shares[0] + 0.02) / (shares[1] + 0.02))
        + _BEYOND * np.log((above + 0.1) / (below + 0.1))
    )
    named, way = _labelled(pieces, heights, level)
    across = pieces.points - heights[:, None] * axis
    sizes = np.ptp(np.percentile(across, (1.0, 99.0), axis=0), axis=0)
    along = float(np.ptp(np.percentile(heights, (1.0, 99.0))))
    tall = (top - bottom) / scale if closed and top - bottom > 2.0 * _COLUMN else None
    extent = along / scale, float(np.linalg.norm(sizes)) / scale
    above_floor = tops - span[0] if upwards >= 0.0 else span[1] - tops
    off = _OFF_ENDS * VOXEL_M
    above_floor = above_floor[(above_floor > off) & (above_floor < span[1] - span[0] - off)]
    shown = len(above_floor) > _TOPS_SHARE * len(pieces)
    low_top = float(np.percentile(above_floor, _LOWER_TOPS)) / scale if shown else None
    return Vertical(axis, float(line) + named, float(upwards) + way, tall, extent, low_top)


def _ends(heights: Array) -> tuple[tuple[float, float], Array] | None:
    """The lowest and the highest large level, and the surfels (2,) of each."""
    if not len(heights):
        return None
    low = float(heights.min())
    counts = np.bincount(((heights - low) / VOXEL_M).astype(int))
    area = np.convolve(np.pad(counts, 2), np.ones(3), "same")
    strong = np.flatnonzero(area > _LEVEL_SHARE * area.max())
    if area.max() < 100:
        return None
    first = int(strong[0] + area[strong[0] : strong[0] + 6].argmax())
    start = max(int(strong[-1]) - 5, 0)
    last = int(start + area[start : strong[-1] + 1].argmax())
    at = tuple(low + (bin_ - 1.5) * VOXEL_M for bin_ in (first, last))
    return (at[0], at[1]), area[[first, last]]


def _standing(
    points: Array, axis: Array, heights: Array, level: Mask, span: tuple[float, float]
) -> tuple[float, Array]:
    """Whether things, and level surfaces, are rather in the lower half; heights of the latter.

    Columns of the plan that are occupied over most of the height, and those near them, are walls
    and what they carry: they say nothing.
    """
    from scipy import ndimage

    first = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    first /= np.linalg.norm(first)
    plan = np.floor(points @ np.column_stack([first, np.cross(axis, first)]) / _COLUMN)
    low, high = np.percentile(plan, (0.5, 99.5), axis=0)
    tenth = np.floor((heights - span[0]) / max(span[1] - span[0], 0.2) * _TENTHS).astype(int)
    kept = ((plan >= low) & (plan <= high)).all(axis=1) & (tenth >= 0) & (tenth < _TENTHS)
    columns, tenth = (plan[kept] - low).astype(int), tenth[kept]
    taken = np.zeros((*(high - low + 1.0).astype(int), _TENTHS), bool)
    taken[columns[:, 0], columns[:, 1], tenth] = True
    walls = taken.sum(axis=2) >= _WALL_TENTHS
    free = ~ndimage.binary_dilation(walls, iterations=_NEAR_WALL_COLUMNS)
    things = (taken & free[:, :, None]).sum(axis=(0, 1))
    top = level[kept] & free[columns[:, 0], columns[:, 1]]
    tops = np.bincount(tenth[top], minlength=_TENTHS)
    return _THINGS * _lower(things) + _TOPS * _lower(tops), heights[kept][top]


def _lower(tenths: Ints) -> float:
    """The logarithm of lower over upper counts, without floor and ceiling, within limits."""
    half = _TENTHS // 2
    ratio = np.log((tenths[1:half].sum() + 30.0) / (tenths[half:-1].sum() + 30.0))
    return float(np.clip(ratio, -_MOST_RATIO, _MOST_RATIO))


def _labelled(pieces: Surfels, heights: Array, level: Mask) -> tuple[float, float]:
    """What labelled floors and ceilings add for an axis, and for its direction."""
    if pieces.label is None:
        return 0.0, 0.0
    line = way = 0.0
    for label, sense in ((_FLOOR_LABEL, 1.0), (_CEILING_LABEL, -1.0)):
        named = pieces.label == label
        if named.sum() > _FEWEST_PIECES // 20 and level[named].mean() > _LABEL_SHARE:
            line += _LABELLED
            way += _LABELLED * sense * np.sign(np.median(heights) - np.median(heights[named]))
    return line, float(way)
