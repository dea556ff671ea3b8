"""Polylines: rounding their corners, measuring along them."""

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array

# Corners that turn by less than this (radians) are left alone.
_STRAIGHT = 1e-6


def filleted(points: ArrayLike, radius: float, *, segments: int = 4, closed: bool = False) -> Array:
    """Replace the corners of a polyline by arcs that touch both neighbours.

    Args:
        points: (N, D) corners, D = 2 or 3, metres.
        radius: Radius of the arcs, metres; smaller where a neighbouring side is too short.
        segments: Straight pieces of each arc.
        closed: Whether the last point joins the first.

    Returns:
        (M, D) the rounded polyline.
    """
    corners = np.asarray(points, dtype=np.float64)
    pieces: list[Array] = []
    for i, corner in enumerate(corners):
        if not closed and i in (0, len(corners) - 1):
            pieces.append(corner[None])
        else:
            before, after = corners[i - 1], corners[(i + 1) % len(corners)]
            pieces.append(_arc(before, corner, after, radius, segments))
    return np.concatenate(pieces)


def _arc(before: Array, corner: Array, after: Array, radius: float, segments: int) -> Array:
    back, ahead = before - corner, after - corner
    sides = float(np.linalg.norm(back)), float(np.linalg.norm(ahead))
    room = 0.499 * min(sides)
    back, ahead = back / sides[0], ahead / sides[1]
    half = 0.5 * float(np.arccos(np.clip(back @ ahead, -1.0, 1.0)))
    turn = np.pi - 2.0 * half
    if turn < _STRAIGHT or half < _STRAIGHT or radius <= 0.0:
        return corner[None]
    tangent = min(radius / float(np.tan(half)), room)
    radius = tangent * float(np.tan(half))
    center = corner + (back + ahead) / (2.0 * np.cos(half)) * (radius / np.sin(half))
    start, end = corner + back * tangent - center, corner + ahead * tangent - center
    t = np.linspace(0.0, 1.0, segments + 1)[:, None]
    arc = center + (np.sin((1.0 - t) * turn) * start + np.sin(t * turn) * end) / np.sin(turn)
    return np.asarray(arc, dtype=np.float64)


def rectangle(width: float, depth: float) -> Array:
    """(4, 2) corners of a rectangle about the origin, counter-clockwise."""
    x, y = 0.5 * width, 0.5 * depth
    return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])


def lengths(points: Array) -> Array:
    """(N,) distance along a polyline from its first point to each of its points."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def signed_area(polygon: Array) -> float:
    """Area of a (N, 2) polygon, positive when it runs counter-clockwise."""
    following = np.roll(polygon, -1, axis=0)
    cross = polygon[:, 0] * following[:, 1] - polygon[:, 1] * following[:, 0]
    return 0.5 * float(cross.sum())
