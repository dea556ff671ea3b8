"""Reflectance disks: what an orthographic camera sees of a point through a parabolic mirror.

The point lies in the focus of a paraboloid, so every ray that runs along the axis meets it: one
picture holds all directions of view, at a few directions of light (H. Zhang, K. Dana, K. Nishino,
Reflectance Hashing for Material Recognition, CVPR 2015; the device: K. Dana and J. Wang, Device
for convenient measurement of spatially varying bidirectional reflectance, JOSA A 21(1), 2004).
Theirs is an off-axis section of such a mirror: the same directions in another picture plane.
"""

from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.floating[Any]]


F0: Final = 0.05


def evaluate(
    albedo: ArrayLike, roughness: ArrayLike, metallic: ArrayLike, to_light: Array, to_eye: Array
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


# Pixels across, and the angles of light from the normal, in the plane of x and z.
RESOLUTION: Final = 25
LIGHTS: Final = (10.0, 40.0, 70.0)
# A narrower highlight falls between the pixels, and the disk no longer changes with it.
LEAST_ROUGHNESS: Final = 0.1
# What a camera's dark noise hides, as reflected radiance per unit of irradiance.
NOISE: Final = 0.003


def directions(x: ArrayLike, y: ArrayLike) -> Array:
    """The direction from the focus that a ray along the mirror's axis comes from.

    The mirror is z = 1 - (x^2 + y^2) / 4: focus at the origin, vertex a unit above it. A ray at
    distance rho from the axis leaves the focus at the angle theta with rho = 2 tan(theta / 2), the
    stereographic projection (S. Baker and S. Nayar, A Theory of Single-Viewpoint Catadioptric Image
    Formation, IJCV 35(2), 1999); the hemisphere is the disk of radius 2.

    Args:
        x: (...,) in focal lengths.
        y: (...,) in focal lengths.

    Returns:
        (..., 3) unit vectors; z is the normal of the sample and the axis of the mirror.
    """
    x, y = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
    q = (x**2 + y**2) / 4
    return np.stack([x / (1 + q), y / (1 + q), (1 - q) / (1 + q)], axis=-1)


@cache
def _pixels() -> Array:
    """(P, 3) directions of view of the pixels whose centres lie inside the disk."""
    centres = (2 * np.arange(RESOLUTION) + 1) / RESOLUTION * 2 - 2
    seen = directions(centres[None, :], centres[:, None]).reshape(-1, 3)
    return np.asarray(seen[seen[:, 2] > 0])


def reflectance_disks(
    albedo: ArrayLike, roughness: ArrayLike, metallic: ArrayLike = 0.0
) -> NDArray[np.float64]:
    """The disks of materials.

    Args:
        albedo: (..., 3) linear base colour.
        roughness: (...,) perceptual; at least `LEAST_ROUGHNESS` is taken.
        metallic: (...,) 0 to 1.

    Returns:
        (..., lights, pixels, 3) reflected radiance for unit irradiance upon a plane that faces the
        light.
    """
    A = np.asarray(albedo, np.float64)[..., None, None, :]
    R = np.maximum(np.asarray(roughness, np.float64), LEAST_ROUGHNESS)[..., None, None]
    m = np.asarray(metallic, np.float64)[..., None, None]
    angles = np.radians(LIGHTS)
    lights = np.stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)], axis=-1)[:, None, :]
    value = evaluate(A, R, m, lights, _pixels()[None, :, :])
    return np.asarray(value * lights[..., 2:], np.float64)


def logarithms(disks: Array) -> NDArray[np.float64]:
    """(..., features) of disks: equal ratios of light become equal steps, as they do to the eye.

    Without it the few pixels of a highlight, which are thousands of times brighter than the rest,
    would be all that a distance sees.
    """
    flat = disks.reshape(*disks.shape[:-3], -1)
    return np.asarray(np.log(flat + NOISE), np.float64)
