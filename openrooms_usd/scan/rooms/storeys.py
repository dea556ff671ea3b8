"""The storeys of a scan: floors above each other, which no plan may mix.

A level surface is the floor of another storey where a ceiling is seen above it, or the ceiling of
the storey below just under it together with walls above. A ceiling that is lower in places has
neither.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.points.surfels import VOXEL_M, Surfels
from openrooms_usd.scan.rooms.directions import UPRIGHT_SINE

_LEVEL_COS: Final = float(np.cos(np.deg2rad(8.0)))
_BIN_M: Final = 0.05
_PIXEL_M: Final = 0.1
_SAME_LEVEL_M: Final = 0.08
# Least height between floors, head room under a ceiling, and thicknesses of the slab between.
_STOREY_M: Final = 2.2
_HEAD_M: Final = 1.9
_SLAB_M: Final = (0.08, 0.8)
# Another storey has at least this area, and this part of the largest one's floor and walls.
_MIN_FLOOR_M2: Final = 4.0
_MIN_SHARE: Final = 0.3
_WALL_BAND_M: Final = (0.3, 1.5)
# What is scanned of a storey below its floor, such as steps, metres.
_BELOW_M: Final = 0.3


@dataclass(frozen=True)
class Storey:
    """One storey.

    Attributes:
        floor: Its height, metres.
        low: Points above this height belong to it, metres.
        high: Points below this height belong to it, metres; infinite for the highest.
        area: Of its floor that was scanned, square metres.
    """

    floor: float
    low: float
    high: float
    area: float


def storeys(pieces: Surfels) -> tuple[Storey, ...]:
    """The storeys of a scan from its lowest floor upwards, at least one.

    Args:
        pieces: Surfels in the level frame, whose lowest floor is at z = 0.
    """
    flat = pieces.points[np.abs(pieces.normals[:, 2]) > _LEVEL_COS]
    walls = pieces.points[np.abs(pieces.normals[:, 2]) < UPRIGHT_SINE, 2]
    floors = [0.0]
    levels = _levels(flat[:, 2])
    for height in levels:
        if height - floors[-1] < _STOREY_M:
            continue
        # The ceiling below a floor has head room above it, too: the floor is the upper of the two.
        over = [top for top in levels if 0.0 < top - height < _SLAB_M[1]]
        known = [_is_floor(top, floors[-1], flat, walls) for top in (height, *over)]
        if known[0] and not any(known[1:]):
            floors.append(height)
    lows = [-np.inf, *(_between(floor, flat[:, 2]) for floor in floors[1:])]
    return tuple(
        Storey(floor, max(low, floor - _BELOW_M), high, _area(_at(flat, floor)))
        for floor, low, high in zip(floors, lows, [*lows[1:], np.inf], strict=True)
    )


def main_storey(found: tuple[Storey, ...]) -> Storey:
    """The storey with the largest floor."""
    return max(found, key=lambda storey: storey.area)


def _levels(heights: Array) -> list[float]:
    """Heights of level surfaces of at least the least floor's area, ascending."""
    if not len(heights):
        return []
    low = float(heights.min()) - 2 * _BIN_M
    counts = np.bincount(((heights - low) / _BIN_M).astype(int))
    area = np.convolve(np.append(counts, np.zeros(4)), np.ones(3), "same") * VOXEL_M**2
    peak = (area[1:-1] >= area[:-2]) & (area[1:-1] > area[2:]) & (area[1:-1] > _MIN_FLOOR_M2)
    return [low + (row + 1.5) * _BIN_M for row in np.flatnonzero(peak).tolist()]


def _is_floor(height: float, below: float, flat: Array, walls: Array) -> bool:
    """Whether a level surface is the floor of the storey above another floor."""
    floor = _at(flat, height)
    least = max(_MIN_FLOOR_M2, _MIN_SHARE * _area(_at(flat, below)))
    over = flat[flat[:, 2] > height + _HEAD_M]
    under = flat[(flat[:, 2] < height - _SLAB_M[0]) & (flat[:, 2] > height - _SLAB_M[1])]
    if _area(_shared(floor, over)) > least:
        return True
    low, high = _WALL_BAND_M
    above, usual = (
        int(((walls > base + low) & (walls < base + high)).sum()) for base in (height, below)
    )
    return _area(_shared(floor, under)) > least and above > _MIN_SHARE * usual


def _at(flat: Array, height: float) -> set[tuple[int, int]]:
    return _pixels(flat[np.abs(flat[:, 2] - height) < _SAME_LEVEL_M])


def _pixels(points: Array) -> set[tuple[int, int]]:
    cells = np.unique(np.floor(points[:, :2] / _PIXEL_M).astype(int), axis=0)
    return {(int(x), int(y)) for x, y in cells}


def _shared(floor: set[tuple[int, int]], points: Array) -> set[tuple[int, int]]:
    return floor & _pixels(points)


def _area(pixels: set[tuple[int, int]]) -> float:
    return len(pixels) * _PIXEL_M**2


def _between(floor: float, heights: Array) -> float:
    """The middle of the slab under a floor."""
    thin, thick = _SLAB_M
    under = heights[(heights < floor - thin) & (heights > floor - thick)]
    least = _MIN_FLOOR_M2 / VOXEL_M**2
    return (floor + float(np.median(under))) / 2.0 if len(under) > least else floor - thin
