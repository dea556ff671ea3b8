"""Frames of a stage: its units and up axis against ours (Z up, metres), and prims in it.

Matrices here are for column vectors (``world = M @ local``); USD's are for row vectors.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdGeom

# Still scenes: everything is read at the first time sample, or at the default without any.
TIME: Final = Usd.TimeCode.EarliestTime()

# Turns Y up to Z up by +90 degrees about X: (x, y, z) -> (x, -z, y).
Z_UP_FROM_Y_UP: Final = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)


def matrix(gf: Gf.Matrix4d) -> NDArray[np.float64]:
    """A USD matrix as a (4, 4) array for column vectors."""
    return np.array(gf, dtype=np.float64).T


def gf_matrix(M: NDArray[np.float64]) -> Gf.Matrix4d:
    """A (4, 4) array for column vectors as a USD matrix."""
    return Gf.Matrix4d(np.asarray(M, dtype=np.float64).T)


def world_from_stage(stage: Usd.Stage) -> NDArray[np.float64]:
    """(4, 4) from the stage's own root frame and units to Z up and metres."""
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    turn = Z_UP_FROM_Y_UP if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y else np.eye(4)
    return np.diag([scale, scale, scale, 1.0]) @ turn


def local_to_world(prim: Usd.Prim, cache: UsdGeom.XformCache) -> NDArray[np.float64]:
    """(4, 4) from a prim's frame to the stage's root frame, in stage units."""
    return matrix(cache.GetLocalToWorldTransform(prim))
