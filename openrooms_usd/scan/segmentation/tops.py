"""Tops: horizontal surfaces of furniture, and which of them belong to one piece."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from openrooms_usd.scan.points.surfels import VOXEL_M, Surfels

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

_LEVEL_COS: Final = 0.85
# Lower tops are rugs and thresholds, metres.
_LOWEST_TOP_M: Final = 0.15
# Neighbours on one top are this near in plan and in height, metres.
_NEIGHBOUR_M: Final = 0.1
_STEP_M: Final = 0.03
_SMALLEST_TOP_M2: Final = 0.05
# Two tops are one surface where their heights differ by less, and their edges are nearer, metres.
_SAME_HEIGHT_M: Final = 0.06
_SEAM_M: Final = 0.13
# A lower top is a shelf of the upper one if this part of it lies below.
_BELOW_SHARE: Final = 0.7
_SHELF_SHARE: Final = 0.3
# Seats: their heights; a back or an arm of one is a narrow top that rises beside it, metres.
LOWEST_SEAT_M: Final = 0.25
_SEAT_M: Final = (LOWEST_SEAT_M, 0.62)
_RISES_M: Final = (0.06, 0.75)
_NARROW_M: Final = 0.27
_LARGEST_BACK_FACTOR: Final = 1.5  # of the seat's area: cushions hide much of it
# So far from the seat: cushions lean on backs and hide the rest of it.
_BESIDE_M: Final = 0.22
# Area over squared breadth of the squarest strip: 5 is three times as long as broad.
_STRIP_AREA: Final = 5.0
# The part of a back that must be so near.
_BESIDE_SHARE: Final = 0.4


@dataclass(frozen=True, eq=False)
class Top:
    """A horizontal surface.

    Attributes:
        rows: Its surfels.
        cells: (N, 2) occupied cells of the plan, VOXEL_M wide, in metres.
        height: Metres above the floor.
    """

    rows: Rows
    cells: Array
    height: float

    @property
    def area(self) -> float:
        """Square metres."""
        return len(self.cells) * VOXEL_M**2

    @property
    def breadth(self) -> float:
        """The breadth of a strip with its area and outline, whichever way that bends, metres."""
        cells = np.floor(self.cells / VOXEL_M).astype(np.int64)
        cells = cells - cells.min(axis=0) + 3
        full = np.zeros(cells.max(axis=0) + 4, dtype=np.bool_)
        full[tuple(cells.T)] = True
        # Sparse scans have holes, which would count as outline.
        full = ndimage.binary_fill_holes(
            ndimage.binary_closing(full, np.ones((3, 3), dtype=np.bool_))
        )
        sides = sum(int(np.count_nonzero(np.diff(full, axis=axis))) for axis in range(2))
        return 2.0 * VOXEL_M * float(np.count_nonzero(full)) / max(sides, 1)


def tops_of(pieces: Surfels) -> list[Top]:
    """The tops among some surfels, the largest first."""
    level = (np.abs(pieces.normals[:, 2]) > _LEVEL_COS) & (pieces.points[:, 2] > _LOWEST_TOP_M)
    rows = np.flatnonzero(level)
    if not len(rows):
        return []
    squeezed = pieces.points[rows] * [1.0, 1.0, _NEIGHBOUR_M / _STEP_M]
    found = _components(
        len(rows), KDTree(squeezed).query_pairs(_NEIGHBOUR_M, output_type="ndarray")
    )
    tops = [_top(pieces, rows[found == number]) for number in range(int(found.max()) + 1)]
    large = [top for top in tops if top.area >= _SMALLEST_TOP_M2]
    return sorted(large, key=lambda top: -top.area)


def united(tops: list[Top]) -> list[int]:
    """For each top the number of the piece that it belongs to."""
    pairs = [
        (i, k)
        for i, one in enumerate(tops)
        for k, other in enumerate(tops[:i])
        if _belong(*sorted((one, other), key=lambda top: top.height))
    ]
    found = _components(len(tops), np.array(pairs, dtype=np.intp).reshape(-1, 2))
    return [int(number) for number in found]


def _belong(low: Top, high: Top) -> bool:
    """Whether two tops are of one piece: one surface, a shelf, or a seat with its back."""
    gap: Array = np.asarray(KDTree(high.cells).query(low.cells)[0])
    rise = high.height - low.height
    if rise < _SAME_HEIGHT_M:
        return bool(gap.min() < _SEAM_M)
    shelved = (gap < 0.75 * VOXEL_M).mean() > _BELOW_SHARE and low.area > _SHELF_SHARE * high.area
    if shelved:
        return True
    if not (_SEAT_M[0] < low.height < _SEAT_M[1] and _RISES_M[0] < rise < _RISES_M[1]):
        return False
    if high.breadth > _NARROW_M or high.area > _LARGEST_BACK_FACTOR * low.area:
        return False
    if high.area < _STRIP_AREA * high.breadth**2:
        return False
    back: Array = np.asarray(KDTree(low.cells).query(high.cells)[0])
    return bool((back < _BESIDE_M + 0.5 * high.breadth).mean() > _BESIDE_SHARE)


def _top(pieces: Surfels, rows: Rows) -> Top:
    points = pieces.points[rows]
    cells = np.unique(np.floor(points[:, :2] / VOXEL_M).astype(np.int64), axis=0)
    return Top(rows, VOXEL_M * (cells.astype(np.float64) + 0.5), float(np.median(points[:, 2])))


def _components(count: int, pairs: NDArray[np.intp]) -> NDArray[np.int32]:
    if not count:
        return np.zeros(0, dtype=np.int32)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])
