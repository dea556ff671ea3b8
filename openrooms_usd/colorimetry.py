"""Colorimetry: the luminance of linear Rec.709 colours, and the sRGB transfer function.

The transfer function is that of IEC 61966-2-1. Floating point stays as wide as it came.
"""

from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Array

Float = TypeVar("Float", bound=np.floating[Any])

# Of red, green and blue in the luminance of scene-linear Rec.709 (ITU-R BT.709).
LUMINANCE: Final = np.array([0.2126, 0.7152, 0.0722])


def luminance(radiance: ArrayLike) -> Array:
    """(...) luminance, nits, of (..., 3) scene-linear Rec.709 radiance in nits."""
    return np.asarray(np.asarray(radiance, dtype=np.float64) @ LUMINANCE)


def srgb_from_linear(linear: NDArray[Float]) -> NDArray[Float]:
    """(...) what a display is sent for linear values; what is outside of [0, 1] is clipped."""
    x = np.clip(linear, 0.0, 1.0)
    curved = 1.055 * np.maximum(x, 0.0031308) ** (1.0 / 2.4) - 0.055
    return np.asarray(np.where(x <= 0.0031308, 12.92 * x, curved), linear.dtype)


def linear_from_srgb(encoded: NDArray[Float]) -> NDArray[Float]:
    """(...) linear values of sRGB-encoded ones; the curve goes on beyond 0 and 1."""
    curved = ((np.maximum(encoded, 0.04045) + 0.055) / 1.055) ** 2.4
    return np.asarray(np.where(encoded <= 0.04045, encoded / 12.92, curved), encoded.dtype)
