"""Writes the transform of a prim with as few operations as possible."""

from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd.usd.places.frames import TIME

_TRANSLATE, _ROTATE, _SCALE, _MATRIX = (
    f"xformOp:{name}" for name in ("translate", "rotateXYZ", "scale", "transform")
)
_ORDER: Final = "xformOpOrder"
_KINDS: Final = {
    _TRANSLATE: Sdf.ValueTypeNames.Double3,
    _ROTATE: Sdf.ValueTypeNames.Float3,
    _SCALE: Sdf.ValueTypeNames.Float3,
    _MATRIX: Sdf.ValueTypeNames.Matrix4d,
}
# Decimals of what is written: micrometres, and millionths of a degree.
_DIGITS: Final = 6
# Smaller changes of an operation's value are ignored (metres, degrees, factors).
_SAME_VALUE_TOLERANCE: Final = 1e-4


def author_placed(spec: Sdf.PrimSpec, prim: Usd.Prim, local: Gf.Matrix4d) -> None:
    """Write the transform of a prim into the operations that it has.

    A prim that is placed by ``translate``, ``rotateXYZ`` and ``scale``, or by nothing, gets new
    values of those that change; one that is placed otherwise gets a matrix in their place.

    Args:
        spec: Receives the opinions.
        prim: The prim as it is composed.
        local: Its new place in its parent's frame.
    """
    parts = _parts(local)
    order = [op.GetOpName() for op in UsdGeom.Xformable(prim).GetOrderedXformOps()]
    usual = [name for name in (_TRANSLATE, _ROTATE, _SCALE) if name in order]
    if order != usual or parts is None or not _is_product(parts, local):
        _write(spec, prim, _MATRIX, local)
        _write_order(spec, [_MATRIX])
        return
    needed = [
        name for name in (_TRANSLATE, _ROTATE, _SCALE) if name in order or not _is_idle(parts, name)
    ]
    before = {name: prim.GetAttribute(name).Get(TIME) for name in order}
    for name in needed:
        if (
            name not in before
            or np.abs(np.subtract(before[name], parts[name])).max() > _SAME_VALUE_TOLERANCE
        ):
            _write(spec, prim, name, parts[name])
    if needed != order:
        _write_order(spec, needed)


def _parts(local: Gf.Matrix4d) -> dict[str, Gf.Vec3d] | None:
    """Translation, degrees about x, y and z, and factors; None for a matrix that has none."""
    rows = np.array(local)[:3, :3]
    lengths = np.linalg.norm(rows, axis=1)
    if not (lengths > 0.0).all() or np.linalg.det(rows) <= 0.0:
        return None
    turn = Gf.Matrix4d(1.0).SetRotate(Gf.Matrix3d(*(rows / lengths[:, None]).ravel().tolist()))
    degrees = turn.ExtractRotation().Decompose(*(Gf.Vec3d(*axis) for axis in np.eye(3)[::-1]))
    found = {
        _TRANSLATE: local.ExtractTranslation(),
        _ROTATE: (degrees[2], degrees[1], degrees[0]),
        _SCALE: lengths.tolist(),
    }
    return {
        name: Gf.Vec3d(*(round(float(x), _DIGITS) + 0.0 for x in values))
        for name, values in found.items()
    }


def _is_product(parts: dict[str, Gf.Vec3d], local: Gf.Matrix4d) -> bool:
    """Whether the operations make the matrix again: a shear cannot be a product of them."""
    x, y, z = (Gf.Rotation(Gf.Vec3d(*axis), parts[_ROTATE][i]) for i, axis in enumerate(np.eye(3)))
    made = Gf.Matrix4d(1.0).SetScale(parts[_SCALE]) * Gf.Matrix4d(1.0).SetRotate(x * y * z)
    made.SetTranslateOnly(parts[_TRANSLATE])
    return bool(np.abs(np.array(made) - np.array(local)).max() < _SAME_VALUE_TOLERANCE)


def _is_idle(parts: dict[str, Gf.Vec3d], name: str) -> bool:
    neutral = 1.0 if name == _SCALE else 0.0
    return bool(np.abs(np.array(parts[name]) - neutral).max() <= _SAME_VALUE_TOLERANCE)


def _write(spec: Sdf.PrimSpec, prim: Usd.Prim, name: str, value: Any) -> None:
    known = prim.GetAttribute(name)
    kind = known.GetTypeName() if known else _KINDS[name]
    made = spec.attributes.get(name) or Sdf.AttributeSpec(spec, name, kind)
    made.default = kind.type.pythonClass(value) if name != _MATRIX else value


def _write_order(spec: Sdf.PrimSpec, order: list[str]) -> None:
    made = spec.attributes.get(_ORDER) or Sdf.AttributeSpec(
        spec, _ORDER, Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform
    )
    made.default = order
