"""Groups the surfels of a room's contents into pieces of furniture.

Tops are seeds: a piece is what can be reached along the surface from its tops sooner than from
others, where a way over an edge counts as longer. What no top reaches falls into connected parts,
which are cut where they only touch.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.scan.points.surfels import VOXEL_M, Surfels

Numbers = NDArray[np.int32]
Pairs = NDArray[np.intp]

# Surfels touch if they are nearer than this, metres, or than so many times the points' spacing.
_TOUCH_M: Final = 0.085
_TOUCH_SPACINGS: Final = 1.6
# A way over an edge between surfaces counts this many times: pieces that touch meet at edges.
_EDGE_FACTOR: Final = 4.0
_EDGE_COS: Final = 0.7
# Farthest surfel of a piece from its tops, along the surface, metres.
_MAX_REACH_M: Final = 2.2
# What stands on a table or a cabinet begins this far above its top; on seats and beds lies what
# belongs to them, such as pillows. Metres.
_ABOVE_TOP_M: Final = 0.06
_HIGHEST_SEAT_M: Final = 0.62
# A back rises over its seat by so much, has its middle within the outline of what the seat has or
# this near to it, metres, and touches that at so many places for each of its surfels.
_BESIDE_SEAT_M: Final = 0.1
# The least length of a back by that of its seat: a night stand beside a bed is shorter.
_BACK_LENGTH_SHARE: Final = 0.6
_RISES_M: Final = (0.06, 0.75)
_CONTACT_SHARE: Final = 0.15
# Parts that are connected by less than this width are two, metres, unless one is smaller than this.
_NECK_M: Final = 0.15
_SMALLEST_PART_M2: Final = 0.04
_LONGEST_UNCUT_M: Final = 1.2
# Of what is mostly lower than this, metres, the tall part is something else if it covers less than
# this part of the plan.
_LOW_M: Final = 1.1
_MAX_TALL_SHARE: Final = 0.4
# A piece floats if it begins higher than this; what stands on the floor below is its foot if at
# least this part of it does. Metres.
_FLOATS_M: Final = 0.12
_FOOT_M: Final = 0.12
_FOOT_SHARE: Final = 0.6
_LONGEST_FOOT_M: Final = 0.35
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


def grouped(pieces: Surfels, spacing: float) -> Numbers:
    """(M,) the number of the piece that each surfel belongs to.

    Args:
        pieces: The surfels of what stands in a room, floor at z = 0.
        spacing: Of the points that they were made from, metres.
    """
    if not len(pieces):
        return np.zeros(0, dtype=np.int32)
    touch = max(_TOUCH_M, _TOUCH_SPACINGS * spacing)
    pairs = KDTree(pieces.points).query_pairs(touch, output_type="ndarray")
    tops = tops_of(pieces)
    piece_of_top = united(tops)
    found = _spread(pieces, pairs, tops, piece_of_top)
    found = _renumbered(found, _loose_parts(pieces, pairs, found < 0))
    found = _with_backs(pieces, pairs, tops, piece_of_top, found)
    above = _above_tops(pieces, tops, piece_of_top, found)
    found = _renumbered(np.where(above, -1, found), _connected(pairs, above))
    return _with_feet(pieces, found)


def _spread(
    pieces: Surfels, pairs: Pairs, tops: Sequence[Top], piece_of_top: Sequence[int]
) -> Numbers:
    """(M,) the piece whose tops are nearest along the surface; -1 where none is reached."""
    found = np.full(len(pieces), -1, dtype=np.int32)
    for top, number in zip(tops, piece_of_top, strict=True):
        found[top.rows] = number
    seeds = np.flatnonzero(found >= 0)
    if not len(seeds):
        return found
    a, b = pairs.T
    length = np.linalg.norm(pieces.points[b] - pieces.points[a], axis=1)
    edge = np.abs(np.einsum("ij,ij->i", pieces.normals[a], pieces.normals[b])) < _EDGE_COS
    weight = np.maximum(length, 1e-6) * np.where(edge, _EDGE_FACTOR, 1.0)
    distance, _, source = dijkstra(
        coo_array((weight, (a, b)), shape=(len(pieces),) * 2).tocsr(),
        directed=False,
        indices=seeds,
        limit=_MAX_REACH_M,
        min_only=True,
        return_predecessors=True,
    )
    reached = np.isfinite(distance)
    found[reached] = found[source[reached]]
    return found


def _loose_parts(pieces: Surfels, pairs: Pairs, loose: Mask) -> Numbers:
    """(M,) connected parts of some surfels, cut at narrow necks of their plan; -1 for others."""
    found = _connected(pairs, loose)
    for number in range(int(found.max(initial=-1)) + 1):
        rows = np.flatnonzero(found == number)
        points = pieces.points[rows]
        if np.ptp(points[:, :2], axis=0).max(initial=0.0) > _LONGEST_UNCUT_M:
            parts = 2 * _cut(points[:, :2]) + _tall(points)
            parts = np.unique(parts, return_inverse=True)[1]
            found[rows] = np.where(parts == 0, number, found.max() + parts)
    return found


def _tall(points: Array) -> Mask:
    """(N,) which surfels belong to the tall part of something that is mostly low, if it has one.

    A curtain or a wardrobe beside low things reaches higher in a small part of the plan.
    """
    cells = np.floor((points[:, :2] - points[:, :2].min(axis=0)) / VOXEL_M).astype(np.int64)
    reached = np.zeros(cells.max(axis=0) + 1)
    np.maximum.at(reached, tuple(cells.T), points[:, 2])
    tall = ndimage.binary_dilation(reached > _LOW_M)
    if (reached > _LOW_M).sum() > _MAX_TALL_SHARE * (reached > 0.0).sum():
        return np.zeros(len(points), dtype=np.bool_)
    return np.asarray(tall[tuple(cells.T)])


def _cut(plan: Array) -> Ints:
    """(N,) numbers of the parts of a plan (N, 2) that narrow necks connect, from 0."""
    cells = np.floor((plan - plan.min(axis=0)) / VOXEL_M).astype(np.int64) + 2
    full = np.zeros(cells.max(axis=0) + 3, dtype=np.bool_)
    full[tuple(cells.T)] = True
    full = ndimage.binary_fill_holes(ndimage.binary_closing(full))
    wide = ndimage.binary_opening(
        full,
        ndimage.iterate_structure(
            ndimage.generate_binary_structure(2, 1), max(round(0.5 * _NECK_M / VOXEL_M), 1)
        ),
    )
    cores, count = ndimage.label(wide)
    sizes = np.bincount(cores.ravel(), minlength=count + 1) * VOXEL_M**2
    cores[(sizes < _SMALLEST_PART_M2)[cores]] = 0
    kept = np.unique(cores[cores > 0])
    if len(kept) < 2:
        return np.zeros(len(plan), dtype=np.int64)
    nearest = ndimage.distance_transform_edt(
        cores == 0, return_distances=False, return_indices=True
    )
    return np.asarray(np.searchsorted(kept, cores[tuple(nearest)][tuple(cells.T)]))


def _above_tops(
    pieces: Surfels, tops: Sequence[Top], piece_of_top: Sequence[int], found: Numbers
) -> Mask:
    """(M,) whether surfels belong to things that stand on their piece's highest top."""
    above = np.zeros(len(found), dtype=np.bool_)
    for number in set(piece_of_top):
        heights = [t.height for t, n in zip(tops, piece_of_top, strict=True) if n == number]
        if max(heights) > _HIGHEST_SEAT_M:
            above |= (found == number) & (pieces.points[:, 2] > max(heights) + _ABOVE_TOP_M)
    return above


def _with_backs(
    pieces: Surfels, pairs: Pairs, tops: Sequence[Top], piece_of_top: Sequence[int], found: Numbers
) -> Numbers:
    """The same; what rises within the outline of a seat and touches it is its back, or its arm."""
    import shapely

    found = found.copy()
    for top, seat in zip(tops, piece_of_top, strict=True):
        own = found == seat
        if not (LOWEST_SEAT_M < top.height < _HIGHEST_SEAT_M) or not own.any():
            continue
        outline = shapely.MultiPoint(pieces.points[own, :2]).convex_hull.buffer(_BESIDE_SEAT_M)
        length = _length(pieces, np.flatnonzero(own))
        sides = own[pairs]
        touching = found[np.where(sides[:, 0], pairs[:, 1], pairs[:, 0])][sides.sum(axis=1) == 1]
        numbers, contacts = np.unique(touching, return_counts=True)
        for number, contact in zip(numbers.tolist(), contacts.tolist(), strict=True):
            rows = np.flatnonzero(found == number)
            rise = float(np.quantile(pieces.points[rows, 2], 0.98)) - top.height
            if contact < _CONTACT_SHARE * len(rows) or not _RISES_M[0] < rise < _RISES_M[1]:
                continue
            if _length(pieces, rows) < _BACK_LENGTH_SHARE * length:
                continue
            if shapely.contains_xy(outline, *pieces.points[rows, :2].mean(axis=0)):
                found[rows] = seat
    return found


def _length(pieces: Surfels, rows: NDArray[np.intp]) -> float:
    """The longest extent of some surfels in the plan, along the axes or the diagonals, metres."""
    x, y = pieces.points[rows, :2].T
    half = np.sqrt(0.5)
    return max(float(np.ptp(along)) for along in (x, y, half * (x + y), half * (x - y)))


def _with_feet(pieces: Surfels, found: Numbers) -> Numbers:
    """The same; what stands under a seat or a top that nothing carries is joined to it.

    Thin legs and columns are often not scanned, their feet are.
    """
    found = found.copy()
    count = int(found.max(initial=-1)) + 1
    order = np.argsort(found, kind="stable")
    parts = np.split(order, np.cumsum(np.bincount(found, minlength=count))[:-1])
    ends = [
        np.quantile(pieces.points[rows, 2], (0.02, 0.98)) if len(rows) else (0.0, 0.0)
        for rows in parts
    ]
    for number, rows in enumerate(parts):
        if ends[number][0] < _FLOATS_M + _FOOT_M or not len(rows):
            continue
        low, high = pieces.points[rows, :2].min(axis=0), pieces.points[rows, :2].max(axis=0)
        for other, feet in enumerate(parts):
            if not len(feet) or ends[other][0] > _FOOT_M or ends[other][1] > _LONGEST_FOOT_M:
                continue
            plan = pieces.points[feet, :2]
            if ((plan > low) & (plan < high)).all(axis=1).mean() > _FOOT_SHARE:
                found[feet] = number
    return found


def _connected(pairs: Pairs, some: Mask) -> Numbers:
    """(M,) connected parts of some surfels, numbered from 0; -1 for others."""
    a, b = pairs[some[pairs].all(axis=1)].T
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(some),) * 2)
    parts = connected_components(graph, directed=False)[1]
    found = np.full(len(some), -1, dtype=np.int32)
    found[some] = np.unique(parts[some], return_inverse=True)[1]
    return found


def _renumbered(found: Numbers, more: Numbers) -> Numbers:
    """Pieces, and after their numbers those of others where there are none."""
    return np.where(found < 0, more + found.max(initial=-1) + 1, found).astype(np.int32)
