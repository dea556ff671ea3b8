"""Meshes whose material moves them along their normals."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene.triangles import Ints
from openrooms_usd.usd.places.frames import meters_per_unit
from openrooms_usd.usd.shapes.meshes import PlacedMesh, TriangleMesh

MOVED: Final = "displacement moves the points of its mesh, and nothing between them"
"""What is approximated of every mesh that is displaced."""
_LARGE: Final = 1e6
# Instances of one form differ by what rounding leaves of their turns.
_DIGITS: Final = 5


def unit_ball(mesh: PlacedMesh) -> Array:
    """(3, 3) symmetric: the world's ball of a unit of the stage, in the frame of a mesh.

    The step by one along a normal n there is `unit_ball @ n / sqrt(n @ unit_ball @ n)`. Instances
    that are turned and moved share it, so that it is rounded.
    """
    turn = meters_per_unit(mesh.prim.GetStage()) * np.linalg.pinv(mesh.world_from_local[:3, :3])
    ball = turn @ turn.T
    size = np.abs(ball).max()
    step = 10.0 ** (np.floor(np.log10(size)) - _DIGITS) if 0.0 < size < np.inf else 1.0
    # Without negative zeros.
    return np.asarray(np.round(ball / step) * step + 0.0)


def displaced(own: TriangleMesh, rows: Ints, heights: Array, ball: Array) -> TriangleMesh:
    """A mesh with some of its triangles moved along their normals, by the points that it has.

    Where faces of different directions meet, their point moves along the mean of these.

    Args:
        own: It.
        rows: Which of its triangles are wanted.
        heights: (len(rows), 3) how far their corners move, in units of the stage.
        ball: `unit_ball` of where it stands.
    """
    triangles = own.triangles[rows]
    a, b, c = np.moveaxis(own.points[triangles], 1, 0)
    crosses = np.cross(b - a, c - a)
    normals = np.repeat(unit(crosses)[:, None], 3, axis=1)
    if own.normals is not None:
        normals = own.normals[rows].astype(np.float64)
    areas = np.linalg.norm(crosses, axis=1)
    along, far, weight = _at_points(own, triangles, normals, heights, areas)
    steps = along @ ball
    steps /= np.sqrt(np.maximum((steps * along).sum(axis=1, keepdims=True), 1e-300))
    steps *= (far / weight)[:, None]
    moved = own.points + np.where(np.isfinite(steps) & (np.abs(steps) < _LARGE), steps, 0.0)
    # Flat faces keep their normals where all move alike; else they are those of what was moved.
    kept = own.normals if np.ptp(heights) == 0.0 else _smoothed(own, moved)
    return replace(own, points=moved, normals=kept)


def _at_points(
    own: TriangleMesh, triangles: Ints, normals: Array, heights: Array, areas: Array
) -> tuple[Array, Array, Array]:
    """(N, 3) normals and (N,) heights at points, summed by area, and (N,) these areas."""
    share = np.repeat(areas, 3)
    columns = (*normals.reshape(-1, 3).T, heights.ravel(), np.ones(len(share)))
    count, flat = len(own.points), triangles.ravel()
    sums = np.array([np.bincount(flat, share * column, count) for column in columns], np.float64)
    return sums[:3].T, sums[3], np.maximum(sums[4], 1e-300)


def _smoothed(own: TriangleMesh, points: Array) -> np.ndarray | None:
    """(M, 3, 3) smooth normals of moved points; None where the mesh is faceted."""
    if own.normals is None:
        return None
    a, b, c = np.moveaxis(points[own.triangles], 1, 0)
    crosses, flat = np.cross(b - a, c - a), own.triangles.ravel()
    sums = [np.bincount(flat, np.repeat(crosses[:, k], 3), len(points)) for k in range(3)]
    return unit(np.stack(sums, axis=1))[own.triangles].astype(np.float32)
