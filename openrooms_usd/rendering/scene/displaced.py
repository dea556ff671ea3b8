"""Meshes whose material moves them along their normals."""

from dataclasses import replace
from typing import Final

import numpy as np
from pxr import UsdGeom

from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene.pictures import Array, load
from openrooms_usd.rendering.scene.triangles import Ints
from openrooms_usd.usd.shading.surfaces import Texture
from openrooms_usd.usd.shapes.meshes import PlacedMesh, TriangleMesh

_LARGE: Final = 1e6


def displaced(mesh: PlacedMesh, rows: Ints, by: float | Texture, losses: list[str]) -> PlacedMesh:
    """A mesh with some of its triangles moved along their normals, by the points that it has.

    Where faces of different directions meet, their point moves along the mean of these.

    Args:
        mesh: Where it stands.
        rows: Which of its triangles are wanted.
        by: How far, in units of the stage.
        losses: What was approximated is added.
    """
    own, turn = mesh.mesh, np.linalg.inv(mesh.world_from_local[:3, :3])
    triangles = own.triangles[rows]
    a, b, c = np.moveaxis(own.points[triangles], 1, 0)
    crosses = np.cross(b - a, c - a)
    normals = np.repeat(unit(crosses)[:, None], 3, axis=1)
    if own.normals is not None:
        normals = own.normals[rows].astype(np.float64)
    areas = np.linalg.norm(crosses, axis=1)
    along, far, weight = _at_points(own, triangles, normals, _heights(own, rows, by), areas)
    metres = UsdGeom.GetStageMetersPerUnit(mesh.prim.GetStage())
    # Normals go by the inverse transpose; the way back is for points.
    steps = (metres * far / weight)[:, None] * unit(unit(along) @ turn) @ turn.T
    losses.append("displacement moves the points of its mesh, and nothing between them")
    moved = own.points + np.where(np.isfinite(steps) & (np.abs(steps) < _LARGE), steps, 0.0)
    # Flat faces keep their normals where all move alike; else they are those of what was moved.
    kept = own.normals if isinstance(by, float) else _smoothed(own, moved)
    return replace(mesh, mesh=replace(own, points=moved, normals=kept))


def _heights(own: TriangleMesh, rows: Ints, by: float | Texture) -> Array:
    """(M, 3) how far the corners move."""
    if isinstance(by, float):
        return np.full((len(rows), 3), by)
    st = own.uvs.get(by.primvar, own.st)
    if st is None:
        st = np.zeros((len(own.triangles), 3, 2), np.float32)
    channel = "rgba".index("r" if by.channel == "rgb" else by.channel)
    plain = replace(by, scale=(1.0,) * 4, bias=(0.0,) * 4)
    picture = load(plain, 1, (0.0, np.inf), by.uv_matrix)
    looked_up = picture.lookup(st[rows].astype(np.float64))[..., 0]
    return np.asarray(looked_up * by.scale[channel] + by.bias[channel])


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
