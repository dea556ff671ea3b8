"""Emitting area, and what lumen mean for a surface."""

import math

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.usd import frames
from openrooms_usd.usd.profiles import Shaping
from openrooms_usd.usd.tessellation import tessellate


def nits_from_lumen(lumen: float, area: float) -> float:
    """Luminance of a surface that emits evenly and like Lambert: ``L = flux / (pi area)``.

    Args:
        lumen: Luminous flux.
        area: Emitting area, square metres, above 0.
    """
    return lumen / (math.pi * area)


def world_from_prim(prim: Usd.Prim) -> NDArray[np.float64]:
    """(4, 4) from a prim's frame to the world, Z up and metres, for columns."""
    local = frames.local_to_world(prim, UsdGeom.XformCache(Usd.TimeCode.EarliestTime()))
    return frames.world_from_stage(prim.GetStage()) @ local


def world_area(prim: Usd.Prim) -> float:
    """The area of a mesh or an intrinsic shape in the world, square metres.

    0 where it has no sound faces, and of curves and points.
    """
    mesh = _world_mesh(prim)
    return 0.0 if mesh is None else float(mesh.areas().sum())


def flux_share(prim: Usd.Prim, shaping: Shaping | None) -> float:
    """What the flux of a mesh is multiplied with by a shaping; 1 without one."""
    mesh = _world_mesh(prim)
    if shaping is None or mesh is None:
        return 1.0
    corners = mesh.points[mesh.indices[mesh.triangles()[0]]]
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(crosses, axis=1)
    normals = crosses / np.where(doubled > 0.0, doubled, 1.0)[:, None]
    return shaping.mean_over(normals, 0.5 * doubled)


def _world_mesh(prim: Usd.Prim) -> Mesh | None:
    if not prim.IsA(UsdGeom.Mesh):
        shape = tessellate(prim)
        return None if shape is None else shape.transformed(world_from_prim(prim))
    mesh = UsdGeom.Mesh(prim)
    attributes = (
        mesh.GetPointsAttr(),
        mesh.GetFaceVertexCountsAttr(),
        mesh.GetFaceVertexIndicesAttr(),
    )
    values = [attribute.Get(Usd.TimeCode.EarliestTime()) for attribute in attributes]
    if not all(values):
        return None
    points, counts, indices = map(np.array, values)
    if counts.min() < 0 or counts.sum() != len(indices):
        return None
    if indices.min() < 0 or indices.max() >= len(points):
        return None
    local = Mesh(points.astype(np.float64), counts.astype(np.int32), indices.astype(np.int32))
    return local.transformed(world_from_prim(prim))
