"""Emitting area, and what lumen mean for a surface."""

import math

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.usd import frames


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
    """The area of a mesh's surface in the world, square metres; 0 where it has no sound faces."""
    mesh = UsdGeom.Mesh(prim)
    attributes = (
        mesh.GetPointsAttr(),
        mesh.GetFaceVertexCountsAttr(),
        mesh.GetFaceVertexIndicesAttr(),
    )
    values = [attribute.Get(Usd.TimeCode.EarliestTime()) for attribute in attributes]
    if not all(values):
        return 0.0
    points, counts, indices = map(np.array, values)
    if counts.min() < 0 or counts.sum() != len(indices):
        return 0.0
    if indices.min() < 0 or indices.max() >= len(points):
        return 0.0
    local = Mesh(points.astype(np.float64), counts.astype(np.int32), indices.astype(np.int32))
    return float(local.transformed(world_from_prim(prim)).areas().sum())
