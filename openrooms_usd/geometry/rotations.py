"""Rotations for column vectors, counter-clockwise, and the rigid poses that they are part of."""

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array


def in_plan(radians: ArrayLike) -> Array:
    """(..., 2, 2) turns of the plan, counter-clockwise from above, by (...) angles."""
    c, s = np.cos(radians), np.sin(radians)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)


def about_x(radians: float) -> Array:
    """(3, 3) a turn about X, from Y to Z."""
    return about_axis(0, radians)


def about_y(radians: float) -> Array:
    """(3, 3) a turn about Y, from Z to X."""
    return about_axis(1, radians)


def about_z(radians: float) -> Array:
    """(3, 3) a turn about the vertical, counter-clockwise from above: a yaw."""
    return about_axis(2, radians)


def tilted(forward: float, right: float) -> Array:
    """(3, 3) leans forward (towards -Y), then to the right (+X); degrees."""
    return about_y(np.radians(right)) @ about_x(np.radians(forward))


def about_axis(axis: int, radians: float) -> Array:
    """(3, 3) a turn about X, Y or Z, by its number."""
    matrix = np.eye(3)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    c, s = np.cos(radians), np.sin(radians)
    matrix[j, j], matrix[j, k], matrix[k, j], matrix[k, k] = c, -s, s, c
    return matrix


def pose(rotation: ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """(4, 4) matrix of a (3, 3) rotation and an origin."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = origin
    return matrix


def about_point(rotation: Array, point: Array) -> Array:
    """(4, 4) a (3, 3) rotation that leaves a point (3,) where it is."""
    return pose(rotation, point - rotation @ point)


def inverse(rigid: Array) -> Array:
    """(4, 4) the inverse of a rigid pose."""
    back = rigid[:3, :3].T
    return pose(back, -back @ rigid[:3, 3])


def is_rotation(matrix: ArrayLike, tolerance: float = 1e-3) -> bool:
    """Whether a (3, 3) matrix is a proper rotation: orthonormal, not mirrored."""
    R = np.asarray(matrix, dtype=np.float64)
    orthonormal = np.abs(R.T @ R - np.eye(3)).max() <= tolerance
    return bool(np.isfinite(R).all() and orthonormal and np.linalg.det(R) > 0)


def nearest_rotation(matrix: ArrayLike) -> Array:
    """The rotation nearest to a (3, 3) matrix (orthogonal Procrustes), its scale taken away."""
    U, _, Vt = np.linalg.svd(np.asarray(matrix, dtype=np.float64))
    return np.asarray(U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt)
