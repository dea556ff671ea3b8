"""Directions: frames, the distribution of GGX, and the elevations that describe the sky."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.arrays import Ints as Rows

ELEVATIONS: Final = (-90.0, -20.0, -1.0, 1.0, 20.0, 50.0, 90.0)
"""Degrees; the radiance of the surroundings is linear in between."""


def frames_about(normal: Array) -> Array:
    """(N, 3, 3) orthonormal frames with the normal as third column (Duff et al., 2017)."""
    sign = np.where(normal[:, 2] >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + normal[:, 2])
    b = normal[:, 0] * normal[:, 1] * a
    x, y = normal[:, 0], normal[:, 1]
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    second = np.stack([b, sign + y * y * a, -y], axis=-1)
    return np.stack([first, second, normal], axis=-1)


def between_elevations(directions: Array) -> tuple[Rows, Array]:
    """The lower of two `ELEVATIONS` that directions lie between, and the share of the upper."""
    angle = np.degrees(np.arcsin(np.clip(directions[:, 2], -1.0, 1.0)))
    steps = np.array(ELEVATIONS)
    low = np.clip(np.searchsorted(steps, angle, side="right") - 1, 0, len(steps) - 2)
    return low, np.clip((angle - steps[low]) / (steps[low + 1] - steps[low]), 0.0, 1.0)


def visible_normals(view: Array, alpha: float, u: Array) -> Array:
    """(N, 3) half vectors in the distribution of visible normals."""
    stretched = view * [alpha, alpha, 1.0]
    stretched /= np.linalg.norm(stretched, axis=1, keepdims=True)
    frames = frames_about(stretched)
    radius, angle = np.sqrt(u[:, 0]), 2.0 * np.pi * u[:, 1]
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    # The frame's first axis must lie in the plane of the surface.
    flat = np.stack([-stretched[:, 1], stretched[:, 0], np.zeros(len(view))], axis=-1)
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    first = np.where(length > 1e-9, flat / np.maximum(length, 1e-9), frames[..., 0])
    second = np.cross(stretched, first)
    s = 0.5 * (1.0 + stretched[:, 2])
    y = (1.0 - s) * np.sqrt(np.maximum(1.0 - x * x, 0.0)) + s * y
    z = np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))
    half = x[:, None] * first + y[:, None] * second + z[:, None] * stretched
    half = half * [alpha, alpha, 1.0]
    half[:, 2] = np.maximum(half[:, 2], 1e-6)
    return np.asarray(half / np.linalg.norm(half, axis=1, keepdims=True))


def smith_ratio(view: Array, light: Array, alpha: float) -> Array:
    """(N,) height-correlated masking and shadowing over masking of the view alone."""
    lambda_v, lambda_l = (
        0.5 * (np.sqrt(1.0 + alpha**2 * (1.0 / np.maximum(c, 1e-4) ** 2 - 1.0)) - 1.0)
        for c in (view, light)
    )
    return np.asarray((1.0 + lambda_v) / (1.0 + lambda_v + lambda_l))


def lobe_values(normal: Array, view: Array, ahead: Array, alpha: float) -> tuple[Array, Array]:
    """(N, T) GGX over Lambert's for both parts of Schlick's term."""
    half = ahead + view[:, None]
    half /= np.maximum(np.linalg.norm(half, axis=-1, keepdims=True), 1e-9)
    n_h = np.einsum("nti,ni->nt", half, normal)
    v_h = np.clip(np.einsum("nti,ni->nt", half, view), 0.0, 1.0)
    n_l = np.einsum("nti,ni->nt", ahead, normal)
    n_v = np.maximum(np.einsum("ni,ni->n", view, normal), 1e-3)[:, None]
    spread = alpha**2 / (np.pi * (n_h**2 * (alpha**2 - 1.0) + 1.0) ** 2)
    lambda_v, lambda_l = (
        0.5 * (np.sqrt(1.0 + alpha**2 * (1.0 / np.maximum(c, 1e-3) ** 2 - 1.0)) - 1.0)
        for c in (n_v, n_l)
    )
    value = np.pi * spread / ((1.0 + lambda_v + lambda_l) * 4.0 * np.maximum(n_l, 1e-3) * n_v)
    rest = (1.0 - v_h) ** 5
    return value * (1.0 - rest), value * rest
