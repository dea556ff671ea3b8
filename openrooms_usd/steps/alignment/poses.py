"""Poses on furniture prims: what the step writes, and what the edits make of it."""

from typing import Final, TypeAlias

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import about_z, pose, tilted
from openrooms_usd.usd.places.frames import TIME, matrix

_TYPES: Final = Sdf.ValueTypeNames
# These two, and a scale after them, are what `UsdGeom.XformCommonAPI` and most editors write.
_TRANSLATE: Final = "xformOp:translate"
_ROTATE: Final = "xformOp:rotateXYZ"
# Billionths of a metre are rounding of matrix products.
_POSE_DIGITS: Final = 9


Turns: TypeAlias = tuple[float, float]


def matrix_of(x: float, y: float, z: float, yaw: float, tilt: Turns = (0.0, 0.0)) -> Array:
    """(4, 4) from the frame of an object as it is authored; degrees and metres."""
    turns = (float(np.float32(angle)) for angle in tilt)
    return pose(about_z(np.radians(float(np.float32(yaw)))) @ tilted(*turns), (x, y, z))


def author_described(
    prim: Sdf.PrimSpec, x: float, y: float, z: float, yaw: float, tilt: Turns
) -> None:
    """Place an object that stands or lies as it is described; degrees and metres.

    Both operations are written also where they do nothing: an edit of one of them alone must find
    it in their order, whatever the description says later.
    """
    _author(prim, (x, y, z), (*tilt, yaw))


def author_pose(prim: Sdf.PrimSpec, rigid: Array) -> None:
    """Place an object by a (4, 4) rigid motion."""
    R = rigid[:3, :3]
    # R = Rz Ry Rx: about X first, as the name of the operation has it.
    angles = (
        np.arctan2(R[2, 1], R[2, 2]),
        np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0])),
        np.arctan2(R[1, 0], R[0, 0]),
    )
    roll, pitch, yaw = (round(float(np.degrees(angle)), _POSE_DIGITS) + 0.0 for angle in angles)
    x, y, z = (round(value, _POSE_DIGITS) + 0.0 for value in rigid[:3, 3].tolist())
    _author(prim, (x, y, z), (roll, pitch, yaw))


Triple: TypeAlias = tuple[float, float, float]


def _author(prim: Sdf.PrimSpec, position: Triple, turns: Triple) -> None:
    _set(prim, _TRANSLATE, _TYPES.Double3, Gf.Vec3d(*position))
    _set(prim, _ROTATE, _TYPES.Float3, Gf.Vec3f(*turns))
    order = Vt.TokenArray([_TRANSLATE, _ROTATE])
    _set(prim, UsdGeom.Tokens.xformOpOrder, _TYPES.TokenArray, order, Sdf.VariabilityUniform)


def _set(
    prim: Sdf.PrimSpec,
    name: str,
    kind: Sdf.ValueTypeName,
    value: object,
    variability: Sdf.Variability = Sdf.VariabilityVarying,
) -> None:
    known = prim.attributes.get(name)
    spec = known or Sdf.AttributeSpec(prim, name, kind, variability, declaresCustom=False)
    spec.default = value


def moved_by_hand(stage: Usd.Stage) -> frozenset[str]:
    """The names of objects that a composed layer transforms before the step has placed them."""
    furniture = stage.GetPrimAtPath(names.FURNITURE)
    children = furniture.GetAllChildren() if furniture else ()
    return frozenset(
        prim.GetName()
        for prim in children
        if any(name.startswith("xformOp") for name in prim.GetAuthoredPropertyNames())
    )


def composed_pose(prim: Usd.Prim) -> Array:
    """(4, 4) from an object's frame to that of all furniture, however it was written."""
    cache = UsdGeom.XformCache(TIME)
    parent = cache.GetLocalToWorldTransform(prim.GetParent())
    return matrix(cache.GetLocalToWorldTransform(prim) * parent.GetInverse())
