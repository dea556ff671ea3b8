"""Plane fits to noisy points: MSAC, refined by iteratively reweighted total least squares.

MSAC (Torr and Zisserman, "MLESAC", 2000) scores a plane by the sum of truncated squared distances:
unlike RANSAC's count of inliers, it prefers inliers that are near.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array

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
    inliers: NDArray[np.bool_]

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
