"""Writes the transform of a prim with as few operations as possible."""

from typing import Any, Final, NamedTuple

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.usd.places.frames import TIME, local_to_world

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
# Smaller changes of an operation's value are none (metres, degrees, factors).
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
    """Whether the operations make the matrix again: one that shears is no product of them."""
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


# The free-standing walls of a room, as they are on a stage.

_MIN_CORNERS: Final = 3


class StandingWall(NamedTuple):
    """A free-standing wall.

    Attributes:
        path: Of its prim.
        outline: (K, 2) convex, counter-clockwise in the plan of the world, metres; its first edge
            is one of its two faces.
        height: Metres above the floor.
    """

    path: str
    outline: Array
    height: float

    @property
    def faces(self) -> Array:
        """(2, 2, 2) start and end of its two faces; the room is on their left."""
        starts, ends = self.outline, np.roll(self.outline, -1, axis=0)
        along = (ends[0] - starts[0]) / np.linalg.norm(ends[0] - starts[0])
        # The second face runs the other way.
        back = int(np.argmin((ends - starts) @ along))
        return np.array([[ends[0], starts[0]], [ends[back], starts[back]]])


def read_partitions(stage: Usd.Stage) -> tuple[StandingWall, ...]:
    """The active free-standing walls of a composed room, in the world, in its order."""
    walls, cache = stage.GetPrimAtPath(names.WALLS), UsdGeom.XformCache(TIME)
    found = [_read(prim, cache) for prim in (walls.GetChildren() if walls else ())]
    return tuple(wall for wall in found if wall is not None)


def is_partition(prim: Usd.Prim) -> bool:
    """Whether a prim is a free-standing wall."""
    # By its outline: USD leaves schemas that are not registered out of those it lists.
    outline = prim.GetAttribute(names.PARTITION_OUTLINE) if prim else None
    return bool(outline and outline.HasValue())


def _read(prim: Usd.Prim, cache: UsdGeom.XformCache) -> StandingWall | None:
    if not is_partition(prim):
        return None
    given = [prim.GetAttribute(key) for key in (names.PARTITION_OUTLINE, names.PARTITION_HEIGHT)]
    outline, height = (a.Get(TIME) if a and a.HasValue() else None for a in given)
    corners = np.array(() if outline is None else outline, dtype=np.float64).reshape(-1, 2)
    if len(corners) < _MIN_CORNERS or not np.isfinite(corners).all() or height is None:
        return None
    frame = local_to_world(prim, cache)
    placed = corners @ frame[:2, :2].T + frame[:2, 3]
    return StandingWall(str(prim.GetPath()), placed, float(height))
