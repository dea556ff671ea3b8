"""Exact distances from points to triangles, and triangles cut into small ones."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.vectors import doubled_areas

# Samples that a surface is found by: more make distances faster and the surface slower to make.
SAMPLES: Final = 8_000
# Candidates that a point is first compared with, and at most.
CANDIDATES: Final = (6, 192)
# Points times triangles that are compared at once.
MAX_PAIRS: Final = 500_000
# Faces look up whose unit normal's Z is more.
UPWARD_COS: Final = 0.98
# Candidates where the least distance need not be certain.
FEW_CANDIDATES: Final = 3


@dataclass(frozen=True, eq=False)
class Nearest:
    """What lies nearest to some points.

    Attributes:
        distance: (N,) metres to `triangle`.
        triangle: (N,) the row of the nearest one, or where that was not asked for, of one near.
        least: (N,) metres: no triangle is nearer.
    """

    distance: Array
    triangle: Ints
    least: Array


class TriangleSurface:
    """Triangles that distances are measured to, exactly.

    Each triangle is cut into small pieces; the pieces' centres, in a k-d tree, say which triangles
    can be nearest.

    Args:
        corners: (M, 3, 3) metres, M at least 1.
    """

    def __init__(self, corners: Array) -> None:
        from scipy.spatial import cKDTree

        self.corners = corners
        self._table = _table(corners)
        centres, self._of, self._reach = _cells(corners, _piece_size(corners))
        self._tree = cKDTree(centres, balanced_tree=False, compact_nodes=False)

    @cached_property
    def level(self) -> Mask:
        """(M,) which of its triangles look up along +Z."""
        return is_level(self.corners)

    def near(self, points: Array, candidates: int = FEW_CANDIDATES) -> Nearest:
        """A near triangle of each of (N, 3) points, hardly ever not the nearest.

        Its distance is an upper bound, and mostly the least there is.

        Args:
            points: Metres.
            candidates: The more, the surer.
        """
        k = min(candidates, len(self._of))
        far, queried = self._tree.query(points, k=np.arange(1, k + 1))
        found = self._of[np.asarray(queried)]
        squared = self._squared(points, found)
        at, best = np.arange(len(points)), squared.argmin(axis=1)
        distance = np.sqrt(squared[at, best])
        least = np.clip(np.asarray(far)[:, 0] - self._reach, 0.0, distance)
        return Nearest(distance, found[at, best], least)

    def nearest(self, points: Array, enough: ArrayLike = 0.0, *, decided: bool = False) -> Nearest:
        """The nearest triangle of each of (N, 3) points.

        Args:
            points: Metres.
            enough: A number or (N,): what is known to be no farther is not searched on, metres.
            decided: Neither is what is known to be farther.
        """
        needed: Array = np.broadcast_to(np.asarray(enough, dtype=np.float64), (len(points),))
        distance, least = np.full(len(points), np.inf), np.zeros(len(points))
        triangle = np.zeros(len(points), dtype=np.int64)
        left, count = np.arange(len(points)), CANDIDATES[0]
        while len(left):
            k = min(count, len(self._of))
            queried, rows = self._tree.query(points[left], k=np.arange(1, k + 1))
            found, far = self._of[rows], np.asarray(queried)
            squared = self._squared(points[left], found)
            best = squared.argmin(axis=1)
            at = np.arange(len(left))
            distance[left], triangle[left] = np.sqrt(squared[at, best]), found[at, best]
            # Pieces that were not looked at are farther than the last one's centre less its size.
            rest = far[:, -1] - self._reach if k < len(self._of) else np.full(len(left), np.inf)
            least[left] = np.clip(np.minimum(rest, distance[left]), 0.0, None)
            open_ = (least[left] < distance[left]) & (distance[left] > needed[left])
            if decided:
                open_ &= least[left] <= needed[left]
            left, count = left[open_], count * 4
            if k >= CANDIDATES[1]:
                break
        # What is as far from many, such as the middle of a ring, is compared with all.
        every = np.arange(len(self.corners))[None]
        for rows in np.array_split(left, len(left) * len(self.corners) // MAX_PAIRS + 1):
            squared = self._squared(points[rows], np.repeat(every, len(rows), axis=0))
            triangle[rows] = squared.argmin(axis=1)
            distance[rows] = least[rows] = np.sqrt(squared.min(axis=1, initial=np.inf))
        return Nearest(distance, triangle, least)

    def farthest(self, corners: Array, triangle: Ints) -> Array:
        """(N,) how far (N, 3, 3) triangles reach from one each of this surface, metres.

        The distance to a triangle is a convex function, hence greatest at a corner.
        """
        squared = _squared(corners.T, self._table[:, None, triangle])
        return np.asarray(np.sqrt(squared.max(axis=0)))

    def _squared(self, points: Array, triangles: Ints) -> Array:
        """(N, k) squared distances of each of (N, 3) points to (N, k) triangles."""
        return _squared(points.T[:, :, None], self._table[:, triangles])


def is_level(corners: Array) -> Mask:
    """(M,) whether (M, 3, 3) triangles look up along +Z."""
    normals = doubled_areas(corners)
    return np.asarray(normals[:, 2] > UPWARD_COS * np.linalg.norm(normals, axis=1))


def bisected(corners: Array, size: ArrayLike) -> tuple[Array, Ints]:
    """Triangles halved across their longest edge until none is longer than ``size``.

    Args:
        corners: (M, 3, 3) metres.
        size: A number, or (M,) one for each triangle.

    Returns:
        (P, 3, 3) pieces, and (P,) the triangle that each is of.
    """
    of = np.arange(len(corners))
    sizes = np.broadcast_to(np.asarray(size, dtype=np.float64), (len(corners),))
    done, done_of = [corners[:0]], [of[:0]]
    while len(corners):
        length, edge = _longest(corners)
        long = length > sizes[of]
        done.append(corners[~long])
        done_of.append(of[~long])
        corners, of = _halves(corners[long], edge[long]), np.repeat(of[long], 2)
    return np.concatenate(done), np.concatenate(done_of)


def halved(corners: Array) -> Array:
    """(2 M, 3, 3) both halves of each triangle, cut from the middle of its longest edge."""
    return _halves(corners, _longest(corners)[1])


def _halves(corners: Array, edge: Ints) -> Array:
    at = np.arange(len(corners))
    a, b, c = corners[at, edge], corners[at, (edge + 1) % 3], corners[at, (edge + 2) % 3]
    middle = (a + b) / 2.0
    halves = np.empty((len(corners), 2, 3, 3))
    halves[:, 0, 0], halves[:, 0, 1], halves[:, 0, 2] = a, middle, c
    halves[:, 1, 0], halves[:, 1, 1], halves[:, 1, 2] = middle, b, c
    return halves.reshape(-1, 3, 3)


def balls(corners: Array) -> tuple[Array, Array]:
    """(M, 3) centres and (M,) radii of balls that hold the triangles."""
    centres = corners.mean(axis=1)
    away = corners - centres[:, None, :]
    return centres, np.sqrt(np.einsum("ijk,ijk->ij", away, away).max(axis=1))


def squared_distances(points: Array, corners: Array) -> Array:
    """Squared distances of points (..., 3) to triangles (..., 3, 3), metres squared."""
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    return _squared((x, y, z), _table(corners))


def _table(corners: Array) -> Array:
    """(15, ...) what distances to triangles (..., 3, 3) are computed of, number by number.

    The first corner, both edges from it, the unit normal, and the products of the edges.
    """
    a, b, c = (np.moveaxis(corners[..., k, :], -1, 0) for k in range(3))
    ab, ac = b - a, c - a
    normal = np.stack(
        [
            ab[1] * ac[2] - ab[2] * ac[1],
            ab[2] * ac[0] - ab[0] * ac[2],
            ab[0] * ac[1] - ab[1] * ac[0],
        ]
    )
    length = np.sqrt((normal * normal).sum(axis=0))
    normal /= np.where(length > 0.0, length, 1.0)
    products = [(ab * ab).sum(axis=0), (ab * ac).sum(axis=0), (ac * ac).sum(axis=0)]
    return np.concatenate([a, ab, ac, normal, np.stack(products)])


def _squared(points: Sequence[Array] | Array, table: Array) -> Array:
    """Squared distances of points (3, ...) to the triangles of a table (15, ...).

    In the barycentric coordinates of the foot in the triangle's plane; where the foot lies outside,
    the nearest of the three edges counts.
    """
    x, y, z = points[0] - table[0], points[1] - table[1], points[2] - table[2]
    d00, d01, d11 = table[12:]
    d20 = x * table[3] + y * table[4] + z * table[5]
    d21 = x * table[6] + y * table[7] + z * table[8]
    height = x * table[9] + y * table[10] + z * table[11]
    squared = x * x + y * y + z * z
    area = d00 * d11 - d01 * d01
    v, w = d11 * d20 - d01 * d21, d00 * d21 - d01 * d20
    above = (area > 0.0) & (v >= 0.0) & (w >= 0.0) & (v + w <= area)
    along = d21 - d20 - d01 + d00
    edges = np.minimum(
        np.minimum(_to_segment(squared, d20, d00), _to_segment(squared, d21, d11)),
        _to_segment(squared - 2.0 * d20 + d00, along, d11 - 2.0 * d01 + d00),
    )
    return np.asarray(np.where(above, height * height, np.maximum(edges, 0.0)))


def _to_segment(squared: Array, product: Array, length: Array) -> Array:
    """Squared distances to segments.

    Args:
        squared: Of the ways from the starts.
        product: Of these ways with the segments.
        length: The segments' squared lengths.
    """
    share = np.clip(product / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    return np.asarray(squared - share * (2.0 * product - share * length))


def _longest(corners: Array) -> tuple[Array, Ints]:
    """(M,) the length of the longest edge of each triangle, and the corner that it starts from."""
    edges = corners[:, [1, 2, 0]] - corners
    squared = np.einsum("ijk,ijk->ij", edges, edges)
    edge = squared.argmax(axis=1)
    return np.sqrt(squared[np.arange(len(edge)), edge]), edge


def _cells(corners: Array, size: float) -> tuple[Array, Ints, float]:
    """Triangles cut into cells of some size.

    Returns:
        (P, 3) the cells' centres, (P,) the triangle that each is of, and how far a cell reaches
        from its centre at most, metres.
    """
    tip, square, end = np.moveaxis(_right_angled(corners), 1, 0)
    along, across = square - tip, end - square
    slabs = _parts(along, 1.0, size)
    of, slab = _counted(slabs)
    start, stop = slab / slabs[of], (slab + 1) / slabs[of]
    cells = _parts(across[of], stop, size)
    row, cell = _counted(cells)
    low, high = (cell / cells[row])[:, None], ((cell + 1) / cells[row])[:, None]
    of, start, stop = of[row], start[row, None], stop[row, None]
    p, q, r = tip[of], along[of], across[of]
    ends = [p + x * (q + y * r) for x in (start, stop) for y in (low, high)]
    centres = (ends[0] + ends[1] + ends[2] + ends[3]) / 4.0
    away = [np.einsum("ij,ij->i", each - centres, each - centres).max() for each in ends]
    return centres, of // 2, float(np.sqrt(max(away)))


def _right_angled(corners: Array) -> Array:
    """(2 M, 3, 3) triangles cut at their heights.

    The far end of the longer leg comes first, then the right angle.
    """
    edge = _longest(corners)[1]
    at = np.arange(len(corners))
    a, b, c = corners[at, edge], corners[at, (edge + 1) % 3], corners[at, (edge + 2) % 3]
    ab, ac = b - a, c - a
    length = np.einsum("ij,ij->i", ab, ab)
    share = np.einsum("ij,ij->i", ab, ac) / np.where(length > 0.0, length, 1.0)
    foot = a + np.clip(share, 0.0, 1.0)[:, None] * ab
    found = np.stack([np.stack([a, foot, c], axis=1), np.stack([b, foot, c], axis=1)], axis=1)
    found = found.reshape(-1, 3, 3)
    legs = np.linalg.norm(found[:, [0, 2]] - found[:, [1]], axis=2)
    turned = legs[:, 1] > legs[:, 0]
    found[turned] = found[turned][:, ::-1]
    return found


def _parts(vectors: Array, shares: Array | float, size: float) -> Ints:
    """Into how many parts no longer than a size shares of some vectors are cut."""
    lengths = np.linalg.norm(vectors, axis=1) * shares
    return np.asarray(np.maximum(np.ceil(lengths / size), 1.0), dtype=np.int64)


def _counted(numbers: Ints) -> tuple[Ints, Ints]:
    """Each row as often as its number says, and the numbers from 0 for each."""
    rows = np.repeat(np.arange(len(numbers)), numbers)
    return rows, np.arange(len(rows)) - np.repeat(np.cumsum(numbers) - numbers, numbers)


def _piece_size(corners: Array) -> float:
    """The side of cells that gives about `SAMPLES` of them."""
    area = float(np.linalg.norm(doubled_areas(corners), axis=1).sum()) / 2.0
    length = float(_longest(corners)[0].sum())
    # Compact triangles give area / size^2 cells, slivers length / size.
    return max(1.4 * float(np.sqrt(area / SAMPLES)), length / (2.0 * SAMPLES), 1e-6)
