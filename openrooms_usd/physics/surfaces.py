"""Exact distances from points to triangles, and a cover of triangles by small ones."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

# Samples that a surface is found by: more make distances faster and the surface slower to make.
SAMPLES: Final = 8_000
# Candidates that a point is first compared with, and at most.
CANDIDATES: Final = (6, 192)
# Triangles up to which points are compared with all.
FEW_TRIANGLES: Final = 320
# Points times triangles that are compared at once.
PAIRS: Final = 500_000
# Candidates where the least distance need not be certain.
FEW: Final = 3


@dataclass(frozen=True, eq=False)
class Nearest:
    """What lies nearest to some points.

    Attributes:
        distance: (N,) metres to `triangle`.
        triangle: (N,) the row of the nearest one, or where that was not asked for, of one near.
        least: (N,) metres: no triangle is nearer.
    """

    distance: Array
    triangle: Rows
    least: Array


class Surface:
    """Triangles that distances are measured to, exactly.

    Each triangle is bisected until its pieces are small; the pieces' centres, in a k-d tree, say
    which triangles can be nearest.

    Args:
        corners: (M, 3, 3) metres, M at least 1.
    """

    def __init__(self, corners: Array) -> None:
        from scipy.spatial import cKDTree

        self.corners = corners
        pieces, self._of = bisected(corners, _piece_size(corners))
        centres, radii = balls(pieces)
        self._reach = float(radii.max())
        self._tree = cKDTree(centres)

    def near(self, points: Array) -> Nearest:
        """A near triangle of each of (N, 3) points, hardly ever not the nearest.

        Its distance is an upper bound, and mostly the least there is.
        """
        k = min(FEW, len(self._of))
        far, queried = self._tree.query(points, k=np.arange(1, k + 1))
        rows: Rows = np.asarray(queried)
        squared = squared_distances(points[:, None, :], self.corners[self._of[rows]])
        at, best = np.arange(len(points)), squared.argmin(axis=1)
        distance = np.sqrt(squared[at, best])
        least = np.clip(np.asarray(far)[:, 0] - self._reach, 0.0, distance)
        return Nearest(distance, self._of[rows[at, best]], least)

    def nearest(self, points: Array, enough: ArrayLike = 0.0) -> Nearest:
        """The nearest triangle of each of (N, 3) points.

        Args:
            points: Metres.
            enough: A number or (N,): what is known to be no farther is not searched on, metres.
        """
        if len(self.corners) <= FEW_TRIANGLES:
            squared = squared_distances(points[:, None, :], self.corners)
            rows = squared.argmin(axis=1)
            least_of_all = np.sqrt(squared[np.arange(len(points)), rows])
            return Nearest(least_of_all, rows, least_of_all)
        needed: Array = np.broadcast_to(np.asarray(enough, dtype=np.float64), (len(points),))
        distance, least = np.full(len(points), np.inf), np.zeros(len(points))
        triangle = np.zeros(len(points), dtype=np.int64)
        left, count = np.arange(len(points)), CANDIDATES[0]
        while len(left):
            k = min(count, len(self._of))
            queried, rows = self._tree.query(points[left], k=np.arange(1, k + 1))
            found, far = self._of[rows], np.asarray(queried)
            squared = squared_distances(points[left][:, None, :], self.corners[found])
            best = squared.argmin(axis=1)
            at = np.arange(len(left))
            distance[left], triangle[left] = np.sqrt(squared[at, best]), found[at, best]
            # Pieces that were not looked at are farther than the last one's centre less its size.
            rest = far[:, -1] - self._reach if k < len(self._of) else np.full(len(left), np.inf)
            least[left] = np.clip(np.minimum(rest, distance[left]), 0.0, None)
            open_ = (least[left] < distance[left]) & (distance[left] > needed[left])
            left, count = left[open_], count * 4
            if k >= CANDIDATES[1]:
                break
        # What is as far from many, such as the middle of a ring, is compared with all.
        for rows in np.array_split(left, len(left) * len(self.corners) // PAIRS + 1):
            squared = squared_distances(points[rows][:, None, :], self.corners)
            triangle[rows] = squared.argmin(axis=1)
            distance[rows] = least[rows] = np.sqrt(squared.min(axis=1, initial=np.inf))
        return Nearest(distance, triangle, least)


def bisected(corners: Array, size: ArrayLike) -> tuple[Array, Rows]:
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
        long = _longest(corners)[0] > sizes[of]
        done.append(corners[~long])
        done_of.append(of[~long])
        corners, of = halved(corners[long]), np.repeat(of[long], 2)
    return np.concatenate(done), np.concatenate(done_of)


def halved(corners: Array) -> Array:
    """(2 M, 3, 3) both halves of each triangle, cut from the middle of its longest edge."""
    _, edge = _longest(corners)
    turn = (edge[:, None] + np.arange(3)) % 3
    a, b, c = np.moveaxis(np.take_along_axis(corners, turn[:, :, None], axis=1), 1, 0)
    middle = (a + b) / 2.0
    halves = np.stack([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)], axis=1)
    return halves.reshape(-1, 3, 3)


def balls(corners: Array) -> tuple[Array, Array]:
    """(M, 3) centres and (M,) radii of balls that hold the triangles."""
    centres = corners.mean(axis=1)
    away = corners - centres[:, None, :]
    return centres, np.sqrt(np.einsum("ijk,ijk->ij", away, away).max(axis=1))


def squared_distances(points: Array, corners: Array) -> Array:
    """Squared distances of points (..., 3) to triangles (..., 3, 3), metres squared.

    In the barycentric coordinates of the foot in the triangle's plane; where the foot lies outside,
    the nearest of the three edges counts.
    """
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    ab, ac, ap = b - a, c - a, points - a
    d00, d01, d11 = _dot(ab, ab), _dot(ab, ac), _dot(ac, ac)
    d20, d21 = _dot(ap, ab), _dot(ap, ac)
    area = d00 * d11 - d01 * d01
    safe = np.where(area > 0, area, 1.0)
    v, w = (d11 * d20 - d01 * d21) / safe, (d00 * d21 - d01 * d20) / safe
    above = (area > 0) & (v >= 0) & (w >= 0) & (v + w <= 1)
    height = _dot(ap, ap) - v * d20 - w * d21
    bc, bp = c - b, points - b
    edges = np.minimum(
        np.minimum(_to_segment(ap, ab, d20, d00), _to_segment(ap, ac, d21, d11)),
        _to_segment(bp, bc, _dot(bp, bc), _dot(bc, bc)),
    )
    return np.maximum(np.where(above, height, edges), 0.0)


def _to_segment(from_start: Array, along: Array, product: Array, squared: Array) -> Array:
    share = np.clip(product / np.where(squared > 0, squared, 1.0), 0.0, 1.0)
    away = from_start - share[..., None] * along
    return _dot(away, away)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _longest(corners: Array) -> tuple[Array, Rows]:
    edges = np.roll(corners, -1, axis=1) - corners
    squared = _dot(edges, edges)
    edge = squared.argmax(axis=1)
    return np.sqrt(squared[np.arange(len(edge)), edge]), edge


def _piece_size(corners: Array) -> float:
    """The longest edge of pieces that gives about `SAMPLES` of them."""
    a, b, c = np.moveaxis(corners, 1, 0)
    area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0
    length = float(_longest(corners)[0].sum())
    # Compact triangles give area / size^2 pieces, slivers length / size.
    return max(2.0 * float(np.sqrt(area / SAMPLES)), length / (2.0 * SAMPLES), 1e-6)
