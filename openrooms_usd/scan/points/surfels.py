"""Surfels of a scan: one a voxel, each with a normal and the residual of its plane fit.

Whatever looks for planes counts surfels and not points, so that a wall that was scanned a hundred
times weighs as much as one that was scanned once. Normals are the least principal axis of the
points in the 27 voxels around; where a scan is sparse, of the nearest points (see `nearest`).

A window of fixed size that holds enough points of a sparse scan holds both faces of a thin wall,
too. The nearest points are of one face as long as they are closer to each other than the faces;
where noise is as large as their distance, more of them are needed. So each place takes, of fits to
few and to many points around it and its neighbours, the one whose direction is the surest.
"""

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import thin

VOXEL_M: Final = 0.05
# Points are first downsampled to this part of a voxel.
_THINNING_VOXELS: Final = 0.5
# Least points of a plane fit; where there are fewer, the nearest points serve.
_MIN_POINTS: Final = 6
_WIDEST_VOXELS: Final = 4
# Neighbourhoods with less than this part of the usual number of points are outliers.
_STRAY_SHARE: Final = 0.2
# Edge of the cubes within which numbers of points are compared, metres.
_COMPARED_CUBE_M: Final = 0.4
# Points farther than this from the middle are of no room, metres.
_MAX_DISTANCE_M: Final = 60.0
# Points of a fit: a point and its four neighbours on a grid; three rows of three; and more.
_POINTS: Final = (5, 9, 17)
_PARAMETERS: Final = 3  # of a plane
# Fits of so many points around a place are its candidates.
_AROUND: Final = 7
# Largest radius of those, and largest residual, which would else pass outliers for surfaces.
_MAX_RADIUS_M: Final = 0.35
_MAX_OFF_PLANE_M: Final = 0.03
# Points of a surface agree: of the fits of one size this part is parallel, within 25 degrees. Of
# stray points few do.
_AGREEING_SHARE: Final = 0.7
_AGREEING_COS: Final = 0.906


@dataclass(frozen=True, eq=False)
class NearestPlanes:
    """Plane fits at M places.

    Attributes:
        normals: (M, 3) unit.
        rough: (M,) root mean squared residuals, metres.
        spacing: (M,) usual distance of the points, metres.
        flat: (M,) whether the points lie near each other and on a plane.
    """

    normals: Array
    rough: Array
    spacing: Array
    flat: Mask


def nearest_planes(points: Array, places: Array) -> NearestPlanes:
    """Fit planes to the nearest points of places.

    Args:
        points: (N, 3) metres, evenly thinned.
        places: (M, 3) among them.
    """
    from scipy.spatial import KDTree

    if len(points) < max(_POINTS):
        none = np.zeros(len(places))
        return NearestPlanes(np.tile([0.0, 0.0, 1.0], (len(places), 1)), none, none, none > 0.0)
    tree = KDTree(points)
    distance, rows = (np.asarray(found) for found in tree.query(places, k=_AROUND))
    asked, at = np.unique(rows, return_inverse=True)
    reach, around = (np.asarray(found) for found in tree.query(points[asked], k=max(_POINTS)))
    fits = [_fits(points[around[:, :count]], reach[:, count - 1]) for count in _POINTS]
    choice = at.reshape(rows.shape)
    middle, normals, rough, turn = (
        np.concatenate([part[choice] for part in parts], axis=1)
        for parts in zip(*fits, strict=True)
    )
    off = np.maximum(rough, np.abs(((places[:, None] - middle) * normals).sum(axis=2)))
    near = off < _MAX_OFF_PLANE_M
    best = np.where(near, turn, np.inf).argmin(axis=1)
    each = np.arange(len(places))
    chosen = normals[each, best]
    parallel = near & (np.abs((normals * chosen[:, None]).sum(axis=2)) > _AGREEING_COS)
    agreeing = parallel.reshape(len(places), len(_POINTS), _AROUND).mean(axis=2).max(axis=1)
    radius = distance[:, -1]
    flat = (radius < _MAX_RADIUS_M) & near[each, best] & (agreeing > _AGREEING_SHARE)
    return NearestPlanes(chosen, off[each, best], radius * np.sqrt(np.pi / _AROUND), flat)


def _fits(points: Array, reach: Array) -> tuple[Array, Array, Array, Array]:
    """Centroids (F, 3), normals (F, 3), residuals (F,) and turns (F,) of fits to (F, K, 3) points.

    A turn is the standard error of the normal's direction, up to a constant factor.
    """
    count = points.shape[1]
    middle = points.mean(axis=1)
    away = (points - middle[:, None]).reshape(-1, 3)
    total = np.column_stack(moments(away)).reshape(*points.shape[:2], 10).sum(axis=1)
    normals, rough = least_principal_axes(total)
    rough = rough * np.sqrt(count / (count - _PARAMETERS))
    return middle, normals, rough, rough / (np.maximum(reach, 1e-9) * np.sqrt(count))


@dataclass(frozen=True, eq=False)
class Surfels:
    """M surfels.

    Attributes:
        points: (M, 3) their centres, metres.
        normals: (M, 3) unit vectors; the sign is arbitrary.
        rough: (M,) root mean squared residual of the plane fit, metres.
        share: (M,) number of points, weighted by confidence, relative to the surfels around: low
            at the edges of a noisy wall, which is several voxels thick.
        label: (M,) NYU40 classes; None where the scan has none.
    """

    points: Array
    normals: Array
    rough: Array
    share: Array
    label: NDArray[np.int32] | None = None

    def __len__(self) -> int:
        return len(self.points)

    def take(self, rows: NDArray[Any]) -> "Surfels":
        """Some of the surfels, by row numbers or a mask."""
        label = None if self.label is None else self.label[rows]
        return Surfels(
            self.points[rows], self.normals[rows], self.rough[rows], self.share[rows], label
        )

    def moved(self, matrix: Array) -> "Surfels":
        """The surfels after a rigid motion (4, 4)."""
        turn = matrix[:3, :3]
        points = self.points @ turn.T + matrix[:3, 3]
        return Surfels(points, self.normals @ turn.T, self.rough, self.share, self.label)


def surfels(cloud: Cloud, voxel: float = VOXEL_M) -> Surfels:
    """The surfels of a scan.

    Args:
        cloud: Finite points near the origin, metres.
        voxel: Edge length, metres.

    Returns:
        One surfel for each occupied voxel with enough points around, in the order of the voxels.
        The scan's own normals are not used: they may be missing, or noisy.
    """
    near = np.abs(cloud.points - np.median(cloud.points, axis=0)).max(axis=1) < _MAX_DISTANCE_M
    bare = Cloud(cloud.points, label=cloud.label, confidence=cloud.confidence).take(near)
    fine = thin(bare, voxel * _THINNING_VOXELS)
    pieces = thin(fine, voxel)
    normals, rough, count = _planes(fine.points, pieces.points, voxel)
    usual, spread = float(np.median(count)), np.ones(len(pieces))
    lonely = np.flatnonzero(count < _MIN_POINTS)
    if len(lonely):
        found = nearest_planes(fine.points, pieces.points[lonely])
        rows = lonely[found.flat]
        normals[rows], rough[rows] = found.normals[found.flat], found.rough[found.flat]
        spread[rows] = found.spacing[found.flat] / voxel
        count[rows] = np.maximum(usual, _MIN_POINTS)
    kept = (count >= _MIN_POINTS) & (count >= _STRAY_SHARE * usual) & np.isfinite(rough)
    share = _shares(bare, pieces.points, voxel)
    flat = Surfels(pieces.points, normals, rough, share, pieces.label).take(kept)
    return _filled(flat, np.rint(spread[kept]).astype(int), voxel)


def _filled(pieces: Surfels, spread: Ints, voxel: float) -> Surfels:
    """Surfels of sparse places resampled on their planes at the fine spacing."""
    wide = np.clip(spread, 1, _WIDEST_VOXELS)
    parts = [pieces.take(wide == 1)]
    for size in range(2, _WIDEST_VOXELS + 1):
        some = pieces.take(wide == size)
        if len(some):
            across = unit(np.cross(some.normals, np.eye(3)[np.abs(some.normals).argmin(axis=1)]))
            along = np.cross(some.normals, across)
            for u, v in np.stack(np.meshgrid(*[np.arange(size)] * 2), -1).reshape(-1, 2):
                step = voxel * ((u - (size - 1) / 2.0) * across + (v - (size - 1) / 2.0) * along)
                parts.append(replace(some, points=some.points + step))
    return _joined(parts) if len(parts) > 1 else parts[0]


def _joined(parts: list[Surfels]) -> Surfels:
    names = ("points", "normals", "rough", "share")
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    labels = [part.label for part in parts if part.label is not None]
    return Surfels(**joined, label=np.concatenate(labels) if labels else None)


def _shares(cloud: Cloud, places: Array, voxel: float) -> Array:
    """(M,) confidence-weighted points a voxel, relative to the mean of its cube, at most 2."""
    origin = cloud.points.min(axis=0)
    mass = _counts(cloud.points - origin, places - origin, voxel, cloud.confidence)
    blocks = _counts(places - origin, places - origin, _COMPARED_CUBE_M, mass)
    pieces = _counts(places - origin, places - origin, _COMPARED_CUBE_M, None)
    return np.asarray(np.minimum(mass * pieces / np.maximum(blocks, 1e-9), 2.0))


def _counts(points: Array, places: Array, size: float, weight: NDArray[Any] | None) -> Array:
    """(M,) the number, or total weight, of the points in the cube of each place."""
    spans = np.floor(points.max(axis=0) / size).astype(np.int64) + 1
    strides = np.array([spans[1] * spans[2], spans[2], 1])
    cubes, cube = np.unique(np.floor(points / size).astype(np.int64) @ strides, return_inverse=True)
    totals = np.bincount(cube, weight).astype(np.float64)
    at = np.searchsorted(cubes, np.floor(places / size).astype(np.int64) @ strides)
    return np.asarray(totals[np.minimum(at, len(cubes) - 1)])


def _planes(points: Array, places: Array, voxel: float) -> tuple[Array, Array, Array]:
    """Normals (M, 3), residuals (M,) and point counts (M,) of plane fits to 27 voxels each."""
    origin = points.min(axis=0)
    points, places = points - origin, places - origin
    low = -2.0 * voxel
    spans = np.ceil((points.max(axis=0) - low) / voxel).astype(np.int64) + 2
    strides = np.array([spans[1] * spans[2], spans[2], 1])
    keys = np.floor((points - low) / voxel).astype(np.int64) @ strides
    cells, cell = np.unique(keys, return_inverse=True)
    sums = np.column_stack([np.bincount(cell, column) for column in moments(points)])
    asked, place = np.unique(
        np.floor((places - low) / voxel).astype(np.int64) @ strides, return_inverse=True
    )
    offsets = np.array(np.meshgrid(*[(-1, 0, 1)] * 3)).reshape(3, -1).T @ strides
    total = np.zeros((len(asked), sums.shape[1]))
    for offset in offsets:
        at = np.minimum(np.searchsorted(cells, asked + offset), len(cells) - 1)
        total += np.where((cells[at] == asked + offset)[:, None], sums[at], 0.0)
    normals, rough = least_principal_axes(total)
    return normals[place], rough[place], total[place, 0]


def moments(points: Array) -> list[Array]:
    """The columns whose sums are the moments of points (N, 3): ten of (N,)."""
    x, y, z = points.T
    return [np.ones(len(points)), x, y, z, x * x, x * y, x * z, y * y, y * z, z * z]


def least_principal_axes(total: Array) -> tuple[Array, Array]:
    """Normals (M, 3) and root mean squared residuals (M,) of plane fits, from moments (M, 10)."""
    count = np.maximum(total[:, :1], 1.0)
    mean = total[:, 1:4] / count
    second = (total[:, 4:] / count)[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
    spread = second - mean[:, :, None] * mean[:, None, :]
    values, axes = np.linalg.eigh(spread)
    return axes[:, :, 0], np.sqrt(np.maximum(values[:, 0], 0.0))


# Plane fits to noisy points: MSAC, refined by iteratively reweighted total least squares.
#
# MSAC (Torr and Zisserman, "MLESAC", 2000) scores a plane by the sum of truncated squared
# distances: unlike RANSAC's count of inliers, it prefers inliers that are near.

_MSAC_TRIES: Final = 400
_MSAC_SAMPLE: Final = 4000
_REWEIGHTING_ROUNDS: Final = 12
# Tukey's biweight at this many standard deviations is 95 % efficient on clean points.
_TUKEY_SIGMAS: Final = 4.685
_MIN_SIGMA_M: Final = 0.002


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane n . p = n . point.

    Attributes:
        normal: (3,) unit.
        point: (3,) the weighted mean of its points.
        residual: Root mean squared distance of its inliers, metres.
        inliers: (N,) mask of the given points.
    """

    normal: Array
    point: Array
    residual: float
    inliers: Mask

    def heights(self, points: Array) -> Array:
        """(N,) signed distances, positive where the normal points."""
        return np.asarray((points - self.point) @ self.normal)


def fit_plane(points: Array, up: Array, tolerance: float, max_tilt: float) -> Plane | None:
    """The plane of the best MSAC score whose normal is near a direction.

    Args:
        points: (N, 3) metres.
        up: (3,) unit; the result points to its side.
        tolerance: Distance at which a point becomes an outlier, metres.
        max_tilt: Largest angle between the normal and ``up``, degrees.

    Returns:
        The plane, or None if no three points span one.
    """
    best = _msac(points, up, tolerance, np.cos(np.deg2rad(max_tilt)))
    if best is None:
        return None
    normal, point = best
    sigma = tolerance / 2.0
    for _ in range(_REWEIGHTING_ROUNDS):
        distance = (points - point) @ normal
        near = np.abs(distance) < tolerance
        if near.sum() < 3:
            return None
        sigma = max(1.4826 * float(np.median(np.abs(distance[near]))), _MIN_SIGMA_M)
        reach = min(_TUKEY_SIGMAS * sigma, tolerance)
        weight = np.clip(1.0 - (distance / reach) ** 2, 0.0, None) ** 2
        normal, point = total_least_squares(points, weight, up)
    distance = (points - point) @ normal
    inliers = np.abs(distance) < max(3.0 * sigma, 0.01)
    residual = float(np.sqrt(np.mean(distance[inliers] ** 2))) if inliers.any() else sigma
    return Plane(normal, point, residual, inliers)


def total_least_squares(points: Array, weight: Array, up: Array) -> tuple[Array, Array]:
    """Normal (3,) on the side of ``up`` and centroid (3,) of the plane of weighted points."""
    middle = np.average(points, axis=0, weights=weight)
    away = points - middle
    normal = np.linalg.eigh((away * weight[:, None]).T @ away)[1][:, 0]
    return (normal if normal @ up >= 0.0 else -normal), middle


def _msac(points: Array, up: Array, tolerance: float, least: float) -> tuple[Array, Array] | None:
    if len(points) < 3:
        return None
    rng = np.random.default_rng(0)
    some = points[rng.permutation(len(points))[:_MSAC_SAMPLE]]
    a, b, c = some[rng.integers(len(some), size=(3, _MSAC_TRIES))]
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    # The normal of a triangle of nearly no area is arbitrary.
    upright = np.abs(normals @ up) >= least * np.maximum(length, 1e-3)
    if not upright.any():
        return None
    normals, a = normals[upright] / length[upright, None], a[upright]
    distance = some @ normals.T - (a * normals).sum(axis=1)
    cost = np.minimum(distance**2, tolerance**2).sum(axis=0)
    best = int(cost.argmin())
    normal = normals[best]
    return (normal if normal @ up >= 0.0 else -normal), a[best]
