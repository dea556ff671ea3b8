"""CAD models that a capture aligned with nine degrees of freedom: as objects, and as boxes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from pxr import Gf, Sdf, UsdGeom, Vt

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.capture import Capture, CapturedBox, CapturedModel
from openrooms_usd.description.furniture import FileObject
from openrooms_usd.furniture import Size, part_of
from openrooms_usd.geometry.rotations import nearest_rotation
from openrooms_usd.geometry.rotations import pose as rigid
from openrooms_usd.portable import relative_text
from openrooms_usd.steps.alignment.captured import Captured
from openrooms_usd.steps.alignment.catalogue import Catalogue
from openrooms_usd.steps.alignment.placement import CaptureSource, Measured, Placement
from openrooms_usd.steps.alignment.poses import author_pose
from openrooms_usd.steps.base import StepContext
from openrooms_usd.usd.places.frames import gf_matrix

_TYPES: Final = Sdf.ValueTypeNames
_SCALE: Final = "xformOp:scale"
_SHIFTED: Final = "xformOp:translate:placed"
_TURNED: Final = "xformOp:orient:placed"
# Smaller rotations and translations are rounding of matrix products.
_STILL_TURN: Final = 1e-9
_MATRIX_DIGITS: Final = 9
# Columns: our right, back and up in the axes of a CAD with Y up, by where its front looks.
_Z_UP: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_FRONTS: Final = {"-Y": 0, "+X": 1, "+Y": 2, "-X": 3}  # quarter turns from -Y


def with_boxes(capture: Capture) -> Capture:
    """A capture in which each CAD model has an upright box, too: what it is without its file."""
    return replace(capture, boxes=(*capture.boxes, *map(_box, capture.models)))


def _box(model: CapturedModel) -> CapturedBox:
    axes = _axes(model)
    M = model.stands
    linear = M[:3, :3] @ axes
    size = 2.0 * np.linalg.norm(linear, axis=0) * (np.abs(axes.T) @ model.half)
    return CapturedBox(
        id=model.id,
        label=model.label,
        center=M[:3, :3] @ model.center + M[:3, 3],
        rotation=linear / np.linalg.norm(linear, axis=0),
        size=size,
    )


def _axes(model: CapturedModel) -> Array:
    """(3, 3) our right, back and up in the CAD's frame, as columns."""
    turn = np.linalg.matrix_power(
        np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), _FRONTS[model.front]
    )
    upright = _Z_UP if model.up == "Y" else np.eye(3)
    return np.asarray(upright.T @ turn)


def placed_model(
    context: StepContext, catalogue: Catalogue, model: CapturedModel, thing: Captured, source: str
) -> Placement:
    """A CAD as an asset at its own size, at the pose that was captured: tilt and scales are kept.

    Args:
        context: The step's.
        catalogue: Makes the asset, one for all that share it.
        model: The CAD; its file is there.
        thing: The same as a box, with its name and its label.
        source: The captured file.

    Raises:
        InputError: The CAD cannot be read.
    """
    assert model.file is not None
    file = relative_text(model.file.resolve(), context.source.resolve())
    item = FileObject(
        **{"from": "file"},
        category=thing.label,
        at=(0.0, 0.0),
        file=file,
        up=model.up,
        front=model.front,
        unit=1.0,
    )
    asset = catalogue.file(item, scaled=True)
    built = asset.build()
    pose = model.stands @ built.file_from_object
    x, y, z = pose[:3, 3].tolist()
    scale = np.linalg.norm(pose[:3, :3], axis=0)
    width, depth, height = (scale * np.ptp(built.extent, axis=0)).tolist()
    size: Size = (width, depth, height)
    return Placement(
        thing.name,
        asset,
        size,
        x,
        y,
        z,
        thing.yaw,
        emits=any(part_of(part) == names.LIGHT_BULB for part in built.parts),
        source=CaptureSource(source, model.id, word=model.label),
        pose=pose,
        shifts=model.shifts,
    )


def author_aligned(prim: Sdf.PrimSpec, pose: Array, placed: Array | None = None) -> None:
    """Place an object by a (4, 4) rotation and translation after a scale along its own axes.

    The operations are those of `UsdGeom.XformCommonAPI`, which most editors write. Where the
    object stands elsewhere, two more take it there, each where it can be seen and switched off:
    ``xformOp:translate:placed`` shifts it, in its parent's axes, ``xformOp:orient:placed`` turns it
    about its own origin.

    Args:
        prim: The object.
        pose: As it was measured.
        placed: Where it can be, after a rigid motion; None: as measured.
    """
    scale = np.linalg.norm(pose[:3, :3], axis=0)
    author_pose(prim, pose @ np.diag([*(1.0 / scale), 1.0]))
    translate, rotate = prim.attributes[UsdGeom.Tokens.xformOpOrder].default
    _set(prim, _SCALE, _TYPES.Float3, Gf.Vec3f(*scale.tolist()))
    order = [translate, rotate, _SCALE]
    moved = pose if placed is None else placed
    turn = nearest_rotation((moved[:3, :3] / scale) @ (pose[:3, :3] / scale).T)
    if np.abs(turn - np.eye(3)).max() > _STILL_TURN:
        around = gf_matrix(rigid(turn, np.zeros(3))).ExtractRotationQuat()
        _set(prim, _TURNED, _TYPES.Quatd, around)
        order.insert(1, _TURNED)
    shift = np.round(moved[:3, 3] - pose[:3, 3], _MATRIX_DIGITS) + 0.0
    if shift.any():
        _set(prim, _SHIFTED, _TYPES.Double3, Gf.Vec3d(*shift.tolist()))
        order.insert(0, _SHIFTED)
    prim.attributes[UsdGeom.Tokens.xformOpOrder].default = Vt.TokenArray(order)


def author_shifted(prim: Sdf.PrimSpec, pose: Array, shifts: Sequence[Array]) -> None:
    """Place an object that was moved after it was measured, each shift on its own.

    ``xformOp:translate:placed`` is the first, ``xformOp:translate:placed_1`` the next.

    Args:
        prim: The object.
        pose: (4, 4) where it stands after all of them.
        shifts: (3,) each, metres, in its parent's axes.
    """
    measured = pose.copy()
    measured[:3, 3] -= sum(shifts, np.zeros(3))
    author_aligned(prim, measured)
    order = list(prim.attributes[UsdGeom.Tokens.xformOpOrder].default)
    for number, shift in enumerate(shifts):
        name = f"{_SHIFTED}_{number}" if number else _SHIFTED
        _set(prim, name, _TYPES.Double3, Gf.Vec3d(*np.round(shift, _MATRIX_DIGITS).tolist()))
        order.insert(0, name)
    prim.attributes[UsdGeom.Tokens.xformOpOrder].default = Vt.TokenArray(order)


def author_measured(prim: Sdf.PrimSpec, found: Measured) -> None:
    """Write the residual, coverage, symmetry and support of an object."""
    apply_schema(prim, names.ALIGNMENT_API)
    _set(prim, names.ALIGNMENT_RESIDUAL, _TYPES.Double, found.residual)
    _set(prim, names.ALIGNMENT_COVERAGE, _TYPES.Double, found.coverage)
    _set(prim, names.ALIGNMENT_SYMMETRY, _TYPES.Token, found.symmetry)
    _set(prim, names.ALIGNMENT_SUPPORT, _TYPES.Token, found.support)
    if found.carrier is not None:
        carrier = Sdf.RelationshipSpec(prim, names.ALIGNMENT_CARRIER, custom=False)
        carrier.targetPathList.explicitItems = [f"{names.FURNITURE}/{found.carrier}"]


def apply_schema(prim: Sdf.PrimSpec, schema: str) -> None:
    """Apply a schema beside those that the prim has."""
    applied = Sdf.TokenListOp()
    known = prim.GetInfo("apiSchemas").prependedItems if prim.HasInfo("apiSchemas") else []
    applied.prependedItems = [*known, schema]
    prim.SetInfo("apiSchemas", applied)


def _set(prim: Sdf.PrimSpec, name: str, kind: Sdf.ValueTypeName, value: object) -> None:
    Sdf.AttributeSpec(prim, name, kind, declaresCustom=False).default = value
