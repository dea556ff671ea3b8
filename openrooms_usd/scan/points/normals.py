"""Normals of a point cloud: least principal axes of neighbourhoods, oriented to the sensors."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.cloud import Cloud

Array = NDArray[np.float64]
Normals = NDArray[np.float32]

# Nearest neighbours, the point included: at 2 cm between points a radius of about 4 cm.
NEIGHBOURS: Final = 16
# Points a batch: bounds the memory of their neighbourhoods.
_POINTS_AT_A_TIME: Final = 1 << 16
_MIN_NEIGHBOURS: Final = 3


def with_normals(cloud: Cloud, neighbours: int = NEIGHBOURS) -> Cloud:
    """The cloud with normals: its own where it has them, estimated ones otherwise.

    Args:
        cloud: N points; its sensor origins give the sign of the normals.
        neighbours: Points a neighbourhood.
    """
    if cloud.normals is not None:
        return cloud
    normals = estimate_normals(cloud.points, neighbours)
    return replace(cloud, normals=towards(normals, views(cloud.points, cloud.sensor_origins)))


def estimate_normals(points: Array, neighbours: int = NEIGHBOURS) -> Normals:
    """Unit normals by principal components of each point's nearest neighbours.

    The normal is the eigenvector of the least eigenvalue of the neighbours' covariance (Hoppe et
    al., "Surface Reconstruction from Unorganized Points", SIGGRAPH 1992, section 3.2). Its sign is
    arbitrary.

    Args:
        points: (N, 3) finite, metres.
        neighbours: Their number, the point included; fewer where the cloud has fewer.

    Returns:
        (N, 3) unit vectors; +Z where the cloud has fewer than three points.
    """
    from scipy.spatial import cKDTree

    count = len(points)
    normals = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (count, 1))
    if count < _MIN_NEIGHBOURS:
        return normals
    # Centred first: far from the origin, differences of coordinates would lose digits.
    local = points - points.mean(axis=0)
    tree = cKDTree(local)
    for start in range(0, count, _POINTS_AT_A_TIME):
        rows = slice(start, start + _POINTS_AT_A_TIME)
        _, near = tree.query(local[rows], min(neighbours, count))
        normals[rows] = _least_principal_axes(local[near])
    return normals


def _least_principal_axes(patches: Array) -> Normals:
    """(B, 3) the least principal axis of each patch (B, K, 3)."""
    offsets = patches - patches.mean(axis=1, keepdims=True)
    covariance = np.einsum("bki,bkj->bij", offsets, offsets)
    return np.asarray(np.linalg.eigh(covariance)[1][:, :, 0], dtype=np.float32)


def towards(normals: Normals, directions: Array) -> Normals:
    """Normals (N, 3), their signs flipped to the side of the directions (N, 3)."""
    away = np.einsum("ni,ni->n", normals, directions) < 0.0
    return np.where(away[:, None], -normals, normals).astype(np.float32)


def views(points: Array, sensor_origins: Array | None) -> Array:
    """(N, 3) the direction from each point to the sensor that probably measured it.

    That is the nearest sensor. Without any it is the median of the points, which is right for the
    walls, floor and ceiling of a convex room and for little else.

    Args:
        points: (N, 3) metres.
        sensor_origins: (V, 3) metres.
    """
    if sensor_origins is None or len(sensor_origins) == 0:
        middle = np.median(points, axis=0) if len(points) else np.zeros(3)
        return np.asarray(middle - points)
    from scipy.spatial import cKDTree

    _, nearest = cKDTree(sensor_origins).query(points)
    return np.asarray(sensor_origins[nearest] - points)
