"""Referenced files whose units or up axis are not the stage's: USD itself converts nothing.

A prim that refers to such a file corrects it by operations of its own, of the names that
Omniverse's metrics assembler writes: ``xformOp:rotateX:unitsResolve`` and
``xformOp:scale:unitsResolve``. Whatever else turns and scales it as much will do.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.usd.places.frames import TIME, meters_per_unit, up_axis

TURN: Final = "xformOp:rotateX:unitsResolve"
SCALE: Final = "xformOp:scale:unitsResolve"

_METRES: Final = UsdGeom.Tokens.metersPerUnit
# Rows of the axes that point up.
_UP: Final = {UsdGeom.Tokens.y: 1, UsdGeom.Tokens.z: 2}
# An axis that is turned less than 45 degrees from up is up.
_UPRIGHT_COS: Final = 0.7


@dataclass(frozen=True, order=True)
class UnitMismatch:
    """A prim whose referenced file has other units or another up axis, uncorrected.

    Attributes:
        path: The prim that refers.
        layer: The identifier of the layer that says so.
        asset: The file, as that layer names it.
        scale: Factor that corrects its coordinates; 1 where they are right.
        turn: Rotation about X that corrects its up axis, degrees; 0 where it is right.
        stated: Whether the file states its units; USD's fallback is centimetres.
    """

    path: str
    layer: str
    asset: str
    scale: float = 1.0
    turn: float = 0.0
    stated: bool = True

    @property
    def operations(self) -> tuple[tuple[str, float], ...]:
        """The operations that are missing, each with its value."""
        found = ((TURN, self.turn, 0.0), (SCALE, self.scale, 1.0))
        return tuple((name, value) for name, value, usual in found if value != usual)

    @property
    def said(self) -> str:
        """What is wrong, and what corrects it."""
        asset = f"@{self.asset}@"
        if not self.stated:
            return f"{asset} does not author its units; the room's are assumed"
        how = ["lies on its side"] if self.turn else []
        if self.scale != 1.0:
            times, way = (1.0 / self.scale, "large") if self.scale < 1.0 else (self.scale, "small")
            how.append(f"is {times:.4g} times too {way}")
        needed = ", ".join(f"{name} = {_literal(name, value)}" for name, value in self.operations)
        return f"{asset} has other axes or units: it {' and '.join(how)}; it needs {needed}"

    def __str__(self) -> str:
        return f"{self.path}: {self.said}"


def _literal(name: str, value: float) -> str:
    return f"({value:.6g}, {value:.6g}, {value:.6g})" if name == SCALE else f"{value:g}"


def find_unit_mismatches(stage: Usd.Stage) -> list[UnitMismatch]:
    """The references and payloads of a stage's own layers whose units nothing corrects.

    References inside of what is referred to, and inside of variants, are not looked at.

    Returns:
        Sorted by path.
    """
    return sorted(
        misfit
        for layer in stage.GetLayerStack(False)
        for spec, asset, root in _referring(layer)
        if (misfit := _misfit(stage, layer, spec, asset, root)) is not None
    )


def _referring(layer: Sdf.Layer) -> Iterator[tuple[Sdf.PrimSpec, str, Sdf.PrimSpec]]:
    """The prims of a layer that refer to other files, and what the root of each file says."""
    # Asked first: it takes a hundredth of the time of a look at every prim.
    if not any(layer.GetCompositionAssetDependencies()):
        return
    known: dict[str, Sdf.Layer | None] = {}
    waiting = list(layer.rootPrims)
    while waiting:
        spec = waiting.pop()
        waiting.extend(spec.nameChildren)
        if not (spec.hasReferences or spec.hasPayloads):
            continue
        for arcs in (spec.referenceList, spec.payloadList):
            for arc in (*arcs.explicitItems, *arcs.prependedItems, *arcs.appendedItems):
                if arc.assetPath not in known:
                    # What is composed is open; nothing else is opened here.
                    found = Sdf.Layer.Find(layer.ComputeAbsolutePath(arc.assetPath))
                    known[arc.assetPath] = found if arc.assetPath else None
                other = known[arc.assetPath]
                if other:
                    yield spec, arc.assetPath, other.pseudoRoot


def _misfit(
    stage: Usd.Stage, layer: Sdf.Layer, spec: Sdf.PrimSpec, asset: str, root: Sdf.PrimSpec
) -> UnitMismatch | None:
    metres, up = meters_per_unit(stage), up_axis(stage)
    stated = root.HasInfo(_METRES)
    # Their fallbacks are centimetres and Y up.
    scale = float(root.GetInfo(_METRES)) / metres
    theirs = root.GetInfo(UsdGeom.Tokens.upAxis) or UsdGeom.Tokens.y
    prim = stage.GetPrimAtPath(spec.path)
    if (np.isclose(scale, 1.0) and theirs == up) or not (prim and prim.IsA(UsdGeom.Xformable)):
        return None
    if not (np.isfinite(scale) and scale > 0.0) or theirs not in _UP:
        return None
    own = _own_linear(UsdGeom.Xformable(prim))
    size = float(np.cbrt(abs(np.linalg.det(own))))
    if not stated:
        # A prim that is scaled or rotated was corrected by hand.
        looked = not np.allclose(own, np.eye(3))
        return (
            None if looked else UnitMismatch(str(spec.path), layer.identifier, asset, stated=False)
        )
    if size == 0.0:
        # What is scaled to nothing has no size to be wrong.
        return None
    if abs(np.log(size / scale)) <= abs(np.log(size)):
        scale = 1.0
    raised = own[_UP[theirs], _UP[up]] / (np.linalg.norm(own[_UP[theirs]]) or 1.0)
    turn = 0.0 if raised > _UPRIGHT_COS else 90.0 if up == UsdGeom.Tokens.z else -90.0
    found = UnitMismatch(str(spec.path), layer.identifier, asset, scale, turn)
    return found if found.operations else None


def _own_linear(xformable: UsdGeom.Xformable) -> Array:
    """(3, 3) what the operations do that the stage's own layers speak of, for row vectors."""
    linear = np.eye(3)
    for op in xformable.GetOrderedXformOps():
        if is_own(op.GetAttr()):
            linear = np.array(op.GetOpTransform(TIME))[:3, :3] @ linear
    return linear


def is_own(attribute: Usd.Attribute) -> bool:
    """Whether the stage's own layers say something of an attribute, not only what they refer to."""
    own = {layer.identifier for layer in attribute.GetStage().GetLayerStack(False)}
    return any(spec.layer.identifier in own for spec in attribute.GetPropertyStack(TIME))
