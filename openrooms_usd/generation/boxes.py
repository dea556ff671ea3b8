"""Upright boxes in the plan, many at a time: do they overlap, and how far is a point from them.

A set of boxes is an (N, 8) array: middle x and y, cosine and sine of the yaw, half width, half
depth, lower and upper height; metres.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Mask

Pose: TypeAlias = tuple[float, float, float]
"""x and y in metres, and the yaw in degrees, counter-clockwise."""

NONE = np.zeros((0, 8))


def box(
    x: float, y: float, width: float, depth: float, low: float, high: float, yaw: float = 0.0
) -> Array:
    """(8,) one box."""
    turn = np.radians(yaw)
    return np.array([x, y, np.cos(turn), np.sin(turn), 0.5 * width, 0.5 * depth, low, high])


def posed(boxes: Array, poses: ArrayLike) -> Array:
    """(P, N, 8) boxes of an object's frame, as they stand at each of (P, 3) poses."""
    x, y, yaw = np.asarray(poses, dtype=np.float64).reshape(-1, 3, 1).swapaxes(0, 1)
    c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
    bx, by, bc, bs = boxes[:, :4].T
    turned = [x + c * bx - s * by, y + s * bx + c * by, c * bc - s * bs, s * bc + c * bs]
    plain = np.broadcast_to(boxes[:, 4:], (len(c), *boxes[:, 4:].shape))
    return np.concatenate([np.stack(turned, axis=-1), plain], axis=-1)


def overlap(a: Array, b: Array, gap: float = 0.0) -> Mask:
    """(..., K) which boxes of (..., 8) ``a`` come nearer than a gap to which of (K, 8) ``b``.

    By the separating axes of two rectangles (exact when the gap is 0, a little wary at corners
    otherwise) and by their heights.

    Args:
        a: Some boxes.
        b: Other boxes.
        gap: What must lie between them, metres; a negative one allows that much overlap.
    """
    p = a[..., None, :]
    dx, dy = b[:, 0] - p[..., 0], b[:, 1] - p[..., 1]
    # Cosine and sine of the angle between the two.
    c = np.abs(p[..., 2] * b[:, 2] + p[..., 3] * b[:, 3])
    s = np.abs(p[..., 2] * b[:, 3] - p[..., 3] * b[:, 2])
    aw, ad, bw, bd = p[..., 4], p[..., 5], b[:, 4], b[:, 5]
    near = (p[..., 6] < b[:, 7] + gap) & (b[:, 6] < p[..., 7] + gap)
    near &= np.abs(p[..., 2] * dx + p[..., 3] * dy) < aw + c * bw + s * bd + gap
    near &= np.abs(p[..., 2] * dy - p[..., 3] * dx) < ad + s * bw + c * bd + gap
    near &= np.abs(b[:, 2] * dx + b[:, 3] * dy) < bw + c * aw + s * ad + gap
    near &= np.abs(b[:, 2] * dy - b[:, 3] * dx) < bd + s * aw + c * ad + gap
    return np.asarray(near)


def distance(boxes: Array, x: Array, y: Array) -> Array:
    """(..., N) horizontal distance of points to boxes; 0 inside.

    Args:
        boxes: (N, 8).
        x: (...) metres.
        y: (...) metres.
    """
    dx, dy = x[..., None] - boxes[:, 0], y[..., None] - boxes[:, 1]
    u = np.abs(boxes[:, 2] * dx + boxes[:, 3] * dy) - boxes[:, 4]
    v = np.abs(boxes[:, 2] * dy - boxes[:, 3] * dx) - boxes[:, 5]
    return np.asarray(np.hypot(np.maximum(u, 0.0), np.maximum(v, 0.0)))


def reach(boxes: Array) -> tuple[float, float, float, float]:
    """Least x and y and greatest x and y of some boxes, metres."""
    c, s = np.abs(boxes[:, 2]), np.abs(boxes[:, 3])
    across, along = c * boxes[:, 4] + s * boxes[:, 5], s * boxes[:, 4] + c * boxes[:, 5]
    low = (boxes[:, :2] - np.stack([across, along], axis=1)).min(axis=0)
    high = (boxes[:, :2] + np.stack([across, along], axis=1)).max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])
