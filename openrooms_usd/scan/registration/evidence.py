"""The points of one object, by instance or box, without outliers."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from scipy import ndimage
from scipy.spatial import KDTree

from openrooms_usd.arrays import Array
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import thin
from openrooms_usd.scan.registration.surroundings import NO_WALLS, Walls

# Largest distance between neighbours in a cluster, metres.
_CLUSTER_GAP_M: Final = 0.08
# Clusters smaller than this part of the largest one are outliers: where the object's place is
# roughly known, and where not.
_STRAY_SHARE_LOCATED: Final = 0.1
_STRAY_SHARE: Final = 0.3
# Points this near to the floor are the floor's, unless the object itself is flatter than the other,
# metres.
_NEAR_FLOOR_M: Final = 0.025
_FLAT_OBJECT_M: Final = 0.12
# Points this near to a wall with its normal are the wall's, and so are those behind it; unless most
# points are, as of a picture.
_NEAR_WALL_M: Final = 0.05
_BEYOND_WALL_M: Final = (-0.5, -0.03)
_FACES_WALL_COS: Final = 0.85
_MAX_WALL_SHARE: Final = 0.5
_WALL_MARGIN_M: Final = 0.1
_NORMAL_NEIGHBOURS: Final = 12
# Finest spacing of points, metres; coarser where an object would have more points than this.
_MIN_SPACING_M: Final = 0.012
_MAX_POINTS: Final = 5000
_SEED: Final = 20100607
# Of the k-d tree: with fewer, queries of points beside a surface take longer.
_LEAF_POINTS: Final = 24


@dataclass(frozen=True, eq=False)
class Evidence:
    """The points of an object.

    Attributes:
        points: (N, 3) metres, of about uniform density, in random order.
        spacing: Between neighbours, metres.
    """

    points: Array
    spacing: float

    @cached_property
    def tree(self) -> "KDTree[None]":
        """k-d tree of all points."""
        return KDTree(self.points, leafsize=_LEAF_POINTS)

    def part(self, count: int) -> Array:
        """A uniform sample of about so many points."""
        return self.points[:: max(len(self.points) // count, 1)]


def gathered(points: Array, bounds: Array | None = None, walls: Walls = NO_WALLS) -> Evidence:
    """The largest clusters of an object's points, downsampled.

    Args:
        points: (N, 3) of one instance, floor at z = 0, with outliers.
        bounds: (2, 3) least and greatest coordinates of inliers; None: any.
        walls: Of the room, whose points may be among them.
    """
    if bounds is not None:
        points = points[((points >= bounds[0]) & (points <= bounds[1])).all(axis=1)]
    points = _clustered(points, _STRAY_SHARE_LOCATED if bounds is not None else _STRAY_SHARE)
    if len(points) and np.quantile(points[:, 2], 0.95) > _FLAT_OBJECT_M:
        points = points[points[:, 2] > _NEAR_FLOOR_M]
    spacing = _MIN_SPACING_M
    thinned = thin(Cloud(points), spacing).points
    while len(thinned) > _MAX_POINTS:
        spacing *= 1.2
        thinned = thin(Cloud(points), spacing).points
    thinned = _off_walls(thinned, walls)
    order = np.random.default_rng(_SEED).permutation(len(thinned))
    return Evidence(thinned[order], max(spacing, 0.02))


def _off_walls(points: Array, walls: Walls) -> Array:
    """Without points of the walls, which labels that bleed over borders bring in."""
    if not len(walls.starts) or len(points) <= _NORMAL_NEIGHBOURS:
        return points
    normals = _normals(points)
    walled = np.zeros(len(points), dtype=np.bool_)
    along = walls.ends - walls.starts
    for start, way, inward in zip(walls.starts, along, walls.normals, strict=True):
        length = float(np.linalg.norm(way))
        station = (points[:, :2] - start) @ way / max(length, 1e-9)
        depth = (points[:, :2] - start) @ inward
        beside = (station > -_WALL_MARGIN_M) & (station < length + _WALL_MARGIN_M)
        facing = np.abs(normals[:, :2] @ inward) > _FACES_WALL_COS
        at = (np.abs(depth) < _NEAR_WALL_M) & facing
        walled |= beside & (at | ((depth > _BEYOND_WALL_M[0]) & (depth < _BEYOND_WALL_M[1])))
    return points[~walled] if walled.mean() < _MAX_WALL_SHARE else points


def _normals(points: Array) -> Array:
    """(N, 3) least principal axes of the nearest points."""
    _, near = KDTree(points).query(points, k=_NORMAL_NEIGHBOURS)
    off = points[near] - points[near].mean(axis=1, keepdims=True)
    return np.asarray(np.linalg.eigh(np.einsum("nki,nkj->nij", off, off))[1][:, :, 0])


def _clustered(points: Array, share: float) -> Array:
    """Without clusters smaller than this share of the largest one."""
    if not len(points):
        return points
    cells = np.floor((points - points.min(axis=0)) / _CLUSTER_GAP_M).astype(np.int64)
    full = np.zeros(cells.max(axis=0) + 1, dtype=np.bool_)
    full[tuple(cells.T)] = True
    pieces, _ = ndimage.label(full, np.ones((3, 3, 3)))
    of_point = pieces[tuple(cells.T)]
    counts = np.bincount(of_point)
    kept = counts[of_point] >= share * counts.max()
    return np.asarray(points[kept])
