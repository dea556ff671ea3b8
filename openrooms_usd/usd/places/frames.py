"""Frames of a stage: its units and up axis against ours (Z up, metres), and prims in it.

Matrices here are for column vectors (``world = M @ local``); USD's are for row vectors.
"""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom

from openrooms_usd.arrays import Array

# Still scenes: everything is read at the first time sample, or at the default without any.
TIME: Final = Usd.TimeCode.EarliestTime()

_FALLBACK_METRES: Final = 0.01

# Turns Y up to Z up by +90 degrees about X: (x, y, z) -> (x, -z, y).
Z_UP_FROM_Y_UP: Final = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)


def matrix(gf: Gf.Matrix4d) -> Array:
    """A USD matrix as a (4, 4) array for column vectors."""
    return np.array(gf, dtype=np.float64).T


def gf_matrix(M: Array) -> Gf.Matrix4d:
    """A (4, 4) array for column vectors as a USD matrix."""
    return Gf.Matrix4d(np.asarray(M, dtype=np.float64).T)


def stated_metres(stage: Usd.Stage) -> float:
    """Metres for one unit as a stage says, which need be no length; not a number of no number.

    USD itself raises where the number is of another type than a double, as old exporters wrote it.
    """
    said = stage.GetMetadata(UsdGeom.Tokens.metersPerUnit)
    is_number = isinstance(said, int | float) and not isinstance(said, bool)
    return float(said) if is_number else float("nan")


def up_axis(stage: Usd.Stage) -> str:
    """The up axis as a stage says, which need be none; USD's fallback where it says nothing."""
    return str(stage.GetMetadata(UsdGeom.Tokens.upAxis) or UsdGeom.Tokens.y)


def meters_per_unit(stage: Usd.Stage) -> float:
    """Metres for one unit of a stage; 0.01, USD's fallback, if not a length."""
    said = stated_metres(stage)
    return said if 0.0 < said < np.inf else _FALLBACK_METRES


def world_from_stage(stage: Usd.Stage) -> Array:
    """(4, 4) from the stage's own root frame and units to Z up and metres."""
    scale = meters_per_unit(stage)
    turn = np.eye(4) if up_axis(stage) == UsdGeom.Tokens.z else Z_UP_FROM_Y_UP
    return np.diag([scale, scale, scale, 1.0]) @ turn


def odd_frame(stage: Usd.Stage) -> list[str]:
    """What a stage says of its units and up axis that cannot be; USD's fallbacks are taken."""
    said, up = stated_metres(stage), up_axis(stage)
    odd = [f"metersPerUnit: {said:g} is not a length; {_FALLBACK_METRES:g} is used"]
    found = odd if said != meters_per_unit(stage) else []
    known = (UsdGeom.Tokens.y, UsdGeom.Tokens.z)
    return found if up in known else [*found, f"upAxis: {str(up)!r} is not an axis; Y is used"]


def local_to_world(prim: Usd.Prim, cache: UsdGeom.XformCache) -> Array:
    """(4, 4) from a prim's frame to the stage's root frame, in stage units.

    Operations that cannot be read, such as a scale that is a text, do nothing.
    """
    try:
        return matrix(cache.GetLocalToWorldTransform(prim))
    except Tf.ErrorException:
        # USD has now reported such operations; the cache holds the result of the others.
        return matrix(cache.GetLocalToWorldTransform(prim))


def local_to_parent(prim: Usd.Prim, cache: UsdGeom.XformCache) -> tuple[Array, bool, str]:
    """(4, 4) of a prim's own operations, whether they start from the root, and what is wrong."""
    try:
        local, resets = cache.GetLocalTransformation(prim)
        return matrix(local), resets, ""
    except Tf.ErrorException:
        shape = UsdGeom.Xformable(prim)
    try:
        M = np.eye(4)
        for op in shape.GetOrderedXformOps():
            M = M @ _operation(op)
        return M, shape.GetResetXformStack(), "operations of its transform cannot be read"
    except Tf.ErrorException:
        return np.eye(4), False, "its transform cannot be read"


def _operation(op: UsdGeom.XformOp) -> Array:
    try:
        return matrix(op.GetOpTransform(TIME))
    except Tf.ErrorException:
        return np.eye(4)


# What `UsdLux.DomeLight.OrientToStageUpAxis` writes.
UPRIGHT: Final = "xformOp:rotateX:orientToStageUpAxis"

_TYPES: Final = {
    "xformOp:translate": Sdf.ValueTypeNames.Double3,
    "xformOp:rotateZ": Sdf.ValueTypeNames.Double,
    UPRIGHT: Sdf.ValueTypeNames.Float,
    "xformOp:transform": Sdf.ValueTypeNames.Matrix4d,
}


def author_placement(prim: Usd.Prim, position: Gf.Vec3d, degrees: float) -> None:
    """Place a prim by a translation, then a rotation about its own vertical.

    Args:
        prim: An xformable prim.
        position: In the parent's frame.
        degrees: Counter-clockwise from above.
    """
    _author(prim, {"xformOp:translate": position, "xformOp:rotateZ": degrees})


def author_upright(prim: Usd.Prim, degrees: float) -> None:
    """Turn a prim whose +Y is up to +Z, then about the vertical, counter-clockwise from above."""
    _author(prim, {"xformOp:rotateZ": degrees, UPRIGHT: 90.0})


def is_upright(prim: Usd.Prim) -> bool:
    """Whether the composed prim still has the operation that `author_upright` turns it up with."""
    order = UsdGeom.Xformable(prim).GetXformOpOrderAttr().Get() or ()
    return UPRIGHT in order


def author_matrix(prim: Usd.Prim, parent_from_prim: Array) -> None:
    """Place a prim by a (4, 4) matrix for column vectors."""
    _author(prim, {"xformOp:transform": gf_matrix(parent_from_prim)})


def _author(prim: Usd.Prim, operations: Mapping[str, Any]) -> None:
    for name, value in operations.items():
        prim.CreateAttribute(name, _TYPES[name], custom=False).Set(value)
    UsdGeom.Xformable(prim).CreateXformOpOrderAttr(list(operations))
