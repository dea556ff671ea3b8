"""Which convex shapes are boxes: engines collide those best, and without a margin."""

from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.triangulation import TriangleMesh

# Relative to the diagonal: points are read in single precision.
_BOX_TOLERANCE_SHARE: Final = 2e-6


@dataclass(frozen=True, eq=False)
class Box:
    """A box somewhere.

    Attributes:
        frame: (4, 4) rigid, from the box's own frame to that of its points; its centre.
        size: (3,) whole lengths along the frame's axes, metres.
    """

    frame: Array
    size: Array


def as_box(mesh: TriangleMesh) -> Box | None:
    """The box that a convex mesh is, or None."""
    corners = np.unique(mesh.points[np.unique(mesh.triangles)], axis=0)
    if len(corners) != 8:
        return None
    centre = corners.mean(axis=0)
    away = corners[1:] - corners[0]
    diagonal = 2.0 * (centre - corners[0])
    tolerance = _BOX_TOLERANCE_SHARE * float(np.abs(corners).max() + np.linalg.norm(diagonal))
    for rows in combinations(range(7), 3):
        edges = away[list(rows)]
        if _spans(edges, diagonal, tolerance) and _has(corners, edges, tolerance):
            turn, size = _sorted(edges)
            frame = np.eye(4)
            frame[:3, :3], frame[:3, 3] = turn, centre
            return Box(frame, size)
    return None


def _spans(edges: Array, diagonal: Array, tolerance: float) -> bool:
    lengths = np.linalg.norm(edges, axis=1)
    if (lengths < 4.0 * tolerance).any():
        return False
    dots = np.abs([edges[0] @ edges[1], edges[1] @ edges[2], edges[2] @ edges[0]])
    # An end of an edge may be off by the tolerance, which turns it by that over its length.
    allowed = 4.0 * tolerance * np.array([lengths[:2].max(), lengths[1:].max(), lengths.max()])
    closed = np.abs(edges.sum(axis=0) - diagonal).max() <= 8.0 * tolerance
    return bool(closed and (dots <= allowed).all())


def _has(corners: Array, edges: Array, tolerance: float) -> bool:
    steps = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    expected = corners[0] + steps @ edges
    gaps = np.abs(expected[:, None] - corners[None]).max(axis=2).min(axis=1)
    return bool((gaps <= 8.0 * tolerance).all())


def _sorted(edges: Array) -> tuple[Array, Array]:
    """The rotation that is nearest to none among those of the box, and the lengths along it."""
    size = np.linalg.norm(edges, axis=1)
    units = edges / size[:, None]
    order: list[int] = []
    for axis in range(3):
        free = [row for row in range(3) if row not in order]
        order.append(max(free, key=lambda row: abs(units[row, axis])))
    turn = units[order].T
    turn = turn * np.where(np.diag(turn) < 0.0, -1.0, 1.0)
    if np.linalg.det(turn) < 0.0:
        turn[:, 2] *= -1.0
    # Exactly orthogonal, the nearest to the edges; how a short one points says little.
    u, _, vt = np.linalg.svd(turn * size[order] ** 2)
    return np.asarray(u @ vt), size[order]
