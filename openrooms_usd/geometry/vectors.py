"""Vectors as rows of arrays."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array

UP: Final = (0.0, 0.0, 1.0)


def crossed(a: Array, b: Array) -> Array:
    """(..., 3) cross products of rows; numpy's own takes several times as long for a few."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    found = np.empty(a.shape)
    found[..., 0], found[..., 1], found[..., 2] = y * w - z * v, z * u - x * w, x * v - y * u
    return found


def doubled_areas(corners: Array) -> Array:
    """(M, 3) normals of (M, 3, 3) triangles, as long as twice their areas."""
    start = corners[:, 0]
    return crossed(corners[:, 1] - start, corners[:, 2] - start)


def unit(vectors: Array, otherwise: ArrayLike | None = None) -> Array:
    """The vectors at length one.

    Args:
        vectors: (..., D).
        otherwise: (D,) what stands for a vector of length zero; without it that stays zero.
    """
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    found = np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0))
    return found if otherwise is None else np.where(lengths > 0.0, found, otherwise)


def points_at(*coordinates: ArrayLike) -> Array:
    """(..., D) points by their D coordinates, which are broadcast against each other."""
    return np.stack(np.broadcast_arrays(*coordinates), axis=-1)
