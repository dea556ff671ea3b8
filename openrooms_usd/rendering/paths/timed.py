"""Cameras of a stage that move: USD's time samples."""

import math

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from openrooms_usd.errors import StageError
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.usd.cameras import FLIP
from openrooms_usd.usd.places.frames import local_to_world, world_from_stage

Array = NDArray[np.float64]


def time_range(prim: Usd.Prim) -> tuple[float, float] | None:
    """The first and the last time code at which a prim or what it stands in moves; None: never."""
    codes: list[float] = []
    while prim and not prim.IsPseudoRoot():
        if xformable := UsdGeom.Xformable(prim):
            codes += xformable.GetTimeSamples()
        prim = prim.GetParent()
    return (min(codes), max(codes)) if len(set(codes)) > 1 else None


def timed_poses(prim: Usd.Prim, times: Array) -> Array:
    """(F, 4, 4) world_from_camera at (F,) seconds after a moving camera's first time sample.

    Raises:
        StageError: Its transform is mirrored or singular at some time.
    """
    codes = time_range(prim)
    first = codes[0] if codes else 0.0
    stage = prim.GetStage()
    world, rate = world_from_stage(stage), stage.GetTimeCodesPerSecond()
    found = []
    for seconds in times:
        cache = UsdGeom.XformCache(Usd.TimeCode(first + seconds * rate))
        placed = world @ local_to_world(prim, cache) @ FLIP
        determinant = np.linalg.det(placed[:3, :3])
        if not (math.isfinite(determinant) and determinant > 0):
            raise StageError(
                f"its transform is mirrored or singular at {seconds:.2f} s",
                place=prim.GetPath(),
                remedy="use rotations and positive scales",
            )
        found.append(pose(nearest_rotation(placed[:3, :3]), placed[:3, 3]))
    return np.array(found)
