"""Lens distortion by OpenCV's model of five coefficients, and pictures seen through such a lens.

D. C. Brown, Close-range camera calibration, Photogrammetric Engineering 37(8), 1971; the order and
the signs are those of OpenCV's ``calib3d``: with x, y the coordinates at depth 1 and r their
length,

    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
    y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.description.dataset import Distortion

Array = NDArray[np.float64]
Pixels = NDArray[np.float32]

_STEPS: Final = 60
# Off by more, at depth 1, a place has no original: the lens folds its picture there.
_FOLDED: Final = 1e-7
# So many places between the middle and an original are looked at for a fold.
_ON_THE_WAY: Final = 16


def distorted(points: Array, lens: Distortion) -> Array:
    """(..., 2) where a lens puts what a pinhole has at (..., 2) coordinates at depth 1."""
    x, y = points[..., 0], points[..., 1]
    r2 = x**2 + y**2
    radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
    return np.stack(
        [
            x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (r2 + 2.0 * x**2),
            y * radial + lens.p1 * (r2 + 2.0 * y**2) + 2.0 * lens.p2 * x * y,
        ],
        axis=-1,
    )


def undistorted(points: Array, lens: Distortion) -> Array:
    """The inverse of `distorted`, by Newton's method; NaN where nothing comes to lie there."""
    found = points.astype(np.float64).copy()
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            step = _solved(_jacobian(found, lens), distorted(found, lens) - points)
            found -= step
            if not (np.abs(step) > _FOLDED**2).any():
                break
        good = np.abs(distorted(found, lens) - points).max(axis=-1) < _FOLDED
        # Beyond a fold lie other originals, which no lens shows; far out it may even unfold again.
        for share in np.linspace(0.0, 1.0, _ON_THE_WAY + 1)[1:]:
            a, b, d = _jacobian(share * found, lens)
            good &= (a * d - b**2 > 0.0) & (a + d > 0.0)
    return np.where(good[..., None], found, np.nan)


def seen_through(pixels: Pixels, K: Array, lens: Distortion) -> tuple[Pixels, NDArray[np.bool_]]:
    """A pinhole's picture as a camera with the same K and a lens has it.

    Args:
        pixels: (height, width, components), means between which there is something.
        K: (3, 3) intrinsics, pixels.
        lens: The lens.

    Returns:
        The picture, by bilinear interpolation, and (height, width) where the pinhole saw what the
        lens shows; 0 elsewhere.
    """
    height, width = pixels.shape[:2]
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    f, c = np.array([K[0, 0], K[1, 1]]), K[:2, 2]
    place = undistorted((np.stack([column, row], axis=-1) - c) / f, lens) * f + c
    inside = ((place >= 0.0) & (place <= (width, height))).all(axis=-1)
    x, y = np.moveaxis(np.where(inside[..., None], place, 0.5) - 0.5, -1, 0)
    # Where nothing moves, pixels stay what they are to the last bit.
    x, y = (np.where(np.abs(v - np.rint(v)) < 1e-9, np.rint(v), v) for v in (x, y))
    left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    found = np.zeros(pixels.shape)
    for i, across in ((0, 1.0 - (x - left)), (1, x - left)):
        for j, down in ((0, 1.0 - (y - top)), (1, y - top)):
            at = np.clip(top + j, 0, height - 1), np.clip(left + i, 0, width - 1)
            found += (across * down)[..., None] * pixels[at]
    return np.where(inside[..., None], found, 0.0).astype(np.float32), inside


def _jacobian(points: Array, lens: Distortion) -> tuple[Array, Array, Array]:
    """dx'/dx, dx'/dy (which is dy'/dx, too) and dy'/dy."""
    x, y = points[..., 0], points[..., 1]
    r2 = x**2 + y**2
    radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
    slope = 2.0 * (lens.k1 + r2 * (2.0 * lens.k2 + r2 * 3.0 * lens.k3))
    return (
        radial + x**2 * slope + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x,
        x * y * slope + 2.0 * lens.p1 * x + 2.0 * lens.p2 * y,
        radial + y**2 * slope + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x,
    )


def _solved(jacobian: tuple[Array, Array, Array], off: Array) -> Array:
    a, b, d = jacobian
    u, v = off[..., 0], off[..., 1]
    return np.asarray(np.stack([d * u - b * v, a * v - b * u], axis=-1) / (a * d - b**2)[..., None])
