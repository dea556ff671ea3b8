"""Plane fits from moments: sums over points that can be added up before anything is fitted."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
