"""OpenRooms' microfacet model in double precision, for any arrays.

It is written apart from the renderer's, so that either can be held against the other.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

F0: Final = 0.05

Array = NDArray[np.floating[Any]]


def evaluate(
    albedo: ArrayLike,
    roughness: ArrayLike,
    metallic: ArrayLike,
    to_light: Array,
    to_eye: Array,
) -> Array:
    """The BRDF of B. Karis (Real Shading in Unreal Engine 4, 2013), as OpenRooms uses it.

    f = A (1 - m) / pi + D F G / (4 (n.l) (n.v)), with the reflectance at normal incidence
    F0 (1 - m) + A m. The denominator of D is written sin2 + R^4 cos2, which does not cancel.

    Args:
        albedo: (..., 3) linear base colour A.
        roughness: (...,) perceptual roughness R, above 0.
        metallic: (...,) metalness m, 0 or 1 or between.
        to_light: (..., 3) unit vectors in the frame whose z is the normal.
        to_eye: (..., 3) unit vectors in that frame.

    Returns:
        (..., 3) per steradian, broadcast; 0 where light or eye is below the surface.
    """
    A = np.asarray(albedo, np.float64)
    R, m = (np.asarray(x, np.float64)[..., None] for x in (roughness, metallic))
    half = to_light + to_eye
    half = half / np.maximum(np.linalg.norm(half, axis=-1, keepdims=True), 1e-300)
    n_l, n_v = to_light[..., 2:], to_eye[..., 2:]
    above = (n_l > 0) & (n_v > 0)
    n_l, n_v = np.where(above, n_l, 1.0), np.where(above, n_v, 1.0)
    v_h = np.sum(to_eye * half, axis=-1, keepdims=True)
    base = F0 * (1 - m) + A * m
    fresnel = (1 - base) * 2.0 ** ((-5.55473 * v_h - 6.98316) * v_h) + base
    k = (R + 1) ** 2 / 8
    # G's cosines and those of the denominator are divided out: grazing angles stay finite.
    shadowing = 1 / ((n_l * (1 - k) + k) * (n_v * (1 - k) + k))
    value = A * (1 - m) / np.pi + distribution(half, R) * fresnel * shadowing / 4
    return np.asarray(np.where(above, value, 0.0))


def distribution(half: Array, roughness: Array) -> Array:
    """Trowbridge-Reitz' D of unit half vectors (..., 3) at roughness (..., 1), per steradian."""
    sine2 = np.sum(half[..., :2] ** 2, axis=-1, keepdims=True)
    alpha2 = roughness**4
    return np.asarray(alpha2 / (np.pi * (sine2 + alpha2 * half[..., 2:] ** 2) ** 2))
