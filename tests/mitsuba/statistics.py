"""Whether two sets of independent renders have the same means, and light in closed form."""

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array


def z_of(a: Array, b: Array) -> Array:
    """How far the means of two sets are apart, in standard errors."""
    spread = a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b)
    return np.asarray((a.mean(axis=0) - b.mean(axis=0)) / np.maximum(np.sqrt(spread), 1e-9))


def blocks(pictures: Array, side: int = 6) -> Array:
    """(..., n) means of blocks of pixels, of each colour."""
    *rest, height, width, _ = pictures.shape
    cut = pictures.reshape(*rest, height // side, side, width // side, side, 3)
    return np.asarray(cut.mean(axis=(-4, -2)).reshape(*rest, -1))


def assert_alike(a: Array, b: Array, what: str = "") -> None:
    """The same means: of the picture, of blocks of pixels, and of pixels."""
    assert np.abs(z_of(a.mean(axis=(1, 2)), b.mean(axis=(1, 2)))).max() < 5.0, what
    z = z_of(blocks(a), blocks(b))
    assert np.abs(z).max() < 6.0 and np.mean(z**2) < 2.2, (what, np.abs(z).max(), np.mean(z**2))
    pixels = z_of(a, b)
    assert np.mean(np.minimum(pixels, 5.0) ** 2) < 1.8, (what, np.mean(pixels**2))


def lambert(at: ArrayLike, normals: ArrayLike, corners: ArrayLike) -> Array:
    """(...) irradiance by an even polygon of radiance 1 above the horizon: Lambert 1760."""
    to = np.asarray(corners, dtype=np.float64) - np.asarray(at)[..., None, :]
    cross = np.cross(to, np.roll(to, -1, axis=-2))
    sine = np.linalg.norm(cross, axis=-1)
    angle = np.arctan2(sine, (to * np.roll(to, -1, axis=-2)).sum(axis=-1))
    share = (cross * np.asarray(normals)[..., None, :]).sum(axis=-1) / np.maximum(sine, 1e-300)
    return np.asarray(np.abs((angle * share).sum(axis=-1)) / 2.0)
