"""Writes the poses at rest after a simulation, beside whatever operations prims already have.

A prim keeps its own operations, whichever program wrote them. A simulation adds one more with the
suffix ``settled``: before all others for an object of the room, after all others for a part that
moves in its own frame, where a door gets one rotation about its hinge.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.usd.places import frames

_SUFFIX: Final = "settled"
_TRANSLATE: Final = f"xformOp:translate:{_SUFFIX}"
_ORIENT: Final = f"xformOp:orient:{_SUFFIX}"
_TRANSFORM: Final = f"xformOp:transform:{_SUFFIX}"
_RESET: Final = "!resetXformStack!"
# Smaller motions are ignored, metres or radians.
_STILL_M_RAD: Final = 1e-9
_RIGID_TOLERANCE: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Motion:
    """How a prim has moved against where the stage shows it.

    Attributes:
        path: The prim.
        world_motion: (4, 4) rigid, of the world to the world: Z up, metres.
        side: Whether the motion is written ``before`` its own operations, or ``after`` them.
    """

    path: str
    world_motion: Array
    side: Literal["before", "after"]


def author_motions(stage: Usd.Stage, motions: Iterable[Motion]) -> list[str]:
    """Write motions as sparse opinions into the edit target.

    Args:
        stage: What the motions were taken from; its edit target holds none of them yet.
        motions: Of each prim at most one. Prims may lie below each other.

    Returns:
        Prims that are not where they should be, because a stronger layer places them.
    """
    ordered = sorted(motions, key=lambda motion: Sdf.Path(motion.path))
    world = frames.world_from_stage(stage)
    cache = UsdGeom.XformCache(frames.TIME)
    wanted: dict[str, Array] = {}
    for motion in ordered:
        prim = stage.GetPrimAtPath(motion.path)
        moved = np.linalg.inv(world) @ motion.world_motion @ world
        wanted[motion.path] = moved @ frames.local_to_world(prim, cache)
    for motion in ordered:
        _author(stage.GetPrimAtPath(motion.path), wanted[motion.path], motion.side)
    return _missed(stage, wanted)


def _author(prim: Usd.Prim, stage_from_prim: Array, side: Literal["before", "after"]) -> None:
    """Add the operations that bring a prim to a pose, its parents being where they shall be."""
    xformable = UsdGeom.Xformable(prim)
    local = frames.matrix(xformable.GetLocalTransformation(frames.TIME))
    resets = xformable.GetResetXformStack()
    cache = UsdGeom.XformCache(frames.TIME)
    parent = np.eye(4) if resets else frames.local_to_world(prim.GetParent(), cache)
    target = np.linalg.inv(parent) @ stage_from_prim
    undone = np.linalg.inv(local)
    added = target @ undone if side == "before" else undone @ target
    own = [name for name in xformable.GetXformOpOrderAttr().Get() or () if name != _RESET]
    # A layer below may hold what another simulation has written.
    again = sum(name.rpartition(":")[2].startswith(_SUFFIX) for name in own)
    suffix = f"_{again}" if again else ""
    operations = {f"{name}{suffix}": what for name, what in _operations(added).items()}
    if not operations:
        return
    for name, (kind, value) in operations.items():
        prim.CreateAttribute(name, kind, custom=False).Set(value)
    order = [*operations, *own] if side == "before" else [*own, *operations]
    xformable.CreateXformOpOrderAttr([_RESET, *order] if resets else order)


def _operations(motion: Array) -> Mapping[str, tuple[Sdf.ValueTypeName, object]]:
    """A motion as a translation and a rotation, each where it does something, or as a matrix."""
    R, t = motion[:3, :3], motion[:3, 3]
    if np.abs(R.T @ R - np.eye(3)).max() > _RIGID_TOLERANCE or np.linalg.det(R) < 0:
        # Below a parent that is stretched, what is rigid in the world is not.
        return {_TRANSFORM: (Sdf.ValueTypeNames.Matrix4d, frames.gf_matrix(motion))}
    found: dict[str, tuple[Sdf.ValueTypeName, object]] = {}
    if np.abs(t).max() > _STILL_M_RAD:
        found[_TRANSLATE] = (Sdf.ValueTypeNames.Double3, Gf.Vec3d(*t.tolist()))
    if np.abs(R - np.eye(3)).max() > _STILL_M_RAD:
        turn = frames.gf_matrix(motion).RemoveScaleShear().ExtractRotationQuat()
        found[_ORIENT] = (Sdf.ValueTypeNames.Quatd, turn)
    return found


def _missed(stage: Usd.Stage, wanted: Mapping[str, Array]) -> list[str]:
    cache = UsdGeom.XformCache(frames.TIME)
    found = ((path, frames.local_to_world(stage.GetPrimAtPath(path), cache)) for path in wanted)
    return [path for path, pose in found if not np.allclose(pose, wanted[path], atol=1e-6)]
