"""Authoring a prim's own transform, whatever a stronger layer says about it.

``UsdGeom.Xformable.AddTranslateOp`` and its kin look at the composed order of operations and refuse
one that is already there. A person who moves a prim in the edits layer makes it so, and the next
run of the stage that placed the prim would fail. These functions write the opinions alone.
"""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd.usd.frames import gf_matrix

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


def author_matrix(prim: Usd.Prim, parent_from_prim: NDArray[np.float64]) -> None:
    """Place a prim by a (4, 4) matrix for column vectors."""
    _author(prim, {"xformOp:transform": gf_matrix(parent_from_prim)})


def _author(prim: Usd.Prim, operations: Mapping[str, Any]) -> None:
    for name, value in operations.items():
        prim.CreateAttribute(name, _TYPES[name], custom=False).Set(value)
    UsdGeom.Xformable(prim).CreateXformOpOrderAttr(list(operations))
