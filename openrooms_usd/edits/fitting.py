"""Brings what the edits refer to from other units and axes to those of the room."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd import claims, names, untrusted
from openrooms_usd.edits.foreign import own_layers
from openrooms_usd.edits.merging import copied
from openrooms_usd.errors import InputError
from openrooms_usd.steps import runner
from openrooms_usd.steps.draft import drafting
from openrooms_usd.usd.files.diagnostics import reading
from openrooms_usd.usd.files.layers import open_stage, stacked_files
from openrooms_usd.usd.places.metrics import SCALE, TURN, UnitMismatch, find_unit_mismatches, is_own

_RESET: Final = "!resetXformStack!"
_INVERTED: Final = "!invert!"
_ORDER: Final = str(UsdGeom.Tokens.xformOpOrder)
_TYPES: Final = {TURN: Sdf.ValueTypeNames.Double, SCALE: Sdf.ValueTypeNames.Double3}


@dataclass(frozen=True)
class Fitting:
    """What was corrected, or would be.

    Attributes:
        edits: The layer that receives it.
        fitted: What got its operations.
        left: Files without units, which cannot be fitted.
    """

    edits: Path
    fitted: tuple[UnitMismatch, ...] = ()
    left: tuple[UnitMismatch, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {**asdict(self), "edits": str(self.edits)}


def fit(out: Path, *, dry_run: bool = False) -> Fitting:
    """Correct the units and axes of the files that a room's edits refer to, by operations there.

    What was scaled and turned already stays as it is; a second call finds nothing.

    Args:
        out: The folder that compose wrote.
        dry_run: Write nothing.

    Raises:
        InputError: There is no composed room, or its edits cannot be read.
        StageError: The room would not compose.
        OutputError: The edits cannot be written.
    """
    edits = _edits_of(out)
    with claims.claimed(out) if not dry_run else nullcontext():
        stage = _opened(edits)
        found = find_unit_mismatches(stage) if stage else []
        fitted = tuple(misfit for misfit in found if misfit.stated)
        left = tuple(misfit for misfit in found if not misfit.stated)
        if stage and fitted and not dry_run:
            with reading(edits), drafting(out) as draft:
                layer = copied(_root_of(stage, edits))
                for misfit in fitted:
                    _correct(layer, stage.GetPrimAtPath(misfit.path), misfit)
                draft.export(layer, names.EDITS)
                runner.check(draft)
    return Fitting(edits, fitted, left)


def misfits_of(out: Path) -> list[UnitMismatch]:
    """What the edits of a composed room refer to in other units or axes, uncorrected.

    Raises:
        InputError: There is no composed room, or its edits cannot be read.
    """
    stage = _opened(_edits_of(out))
    return find_unit_mismatches(stage) if stage else []


def _edits_of(out: Path) -> Path:
    untrusted.check_path(out)
    edits = own_layers(out)[names.STACK.index(names.EDITS)]
    if not edits.is_file():
        raise InputError(
            "no such file", place=edits, remedy="name the folder that orusd compose wrote"
        )
    return edits


def _opened(edits: Path) -> Usd.Stage | None:
    """The room with its edits; None where they say nothing."""
    # The stage keeps its layer alive.
    alone = open_stage(edits)
    said = alone.GetRootLayer()
    if not (said.rootPrims or said.subLayerPaths):
        return None
    with reading(edits):
        return stacked_files(own_layers(edits.parents[1]))


def _root_of(stage: Usd.Stage, edits: Path) -> Sdf.Layer:
    """The layer of the edits, which the room has open."""
    return next(layer for layer in stage.GetLayerStack(False) if layer.realPath == str(edits))


def _correct(layer: Sdf.Layer, prim: Usd.Prim, misfit: UnitMismatch) -> None:
    """Write the missing operations, after those of the room and before those of the file."""
    spec = Sdf.CreatePrimInLayer(layer, prim.GetPath())
    for name, value in misfit.operations:
        attribute = spec.attributes.get(name) or Sdf.AttributeSpec(
            spec, name, _TYPES[name], declaresCustom=False
        )
        attribute.default = Gf.Vec3d(value) if name == SCALE else value
    missing = [name for name, _ in misfit.operations]
    order = spec.attributes.get(_ORDER) or Sdf.AttributeSpec(
        spec, _ORDER, Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform, False
    )
    order.default = _ordered(prim, missing)


def _ordered(prim: Usd.Prim, missing: Sequence[str]) -> list[str]:
    said = UsdGeom.Xformable(prim).GetXformOpOrderAttr().Get() or ()
    order = [name for name in said if name not in missing]
    own = [
        number
        for number, name in enumerate(order)
        if name == _RESET or is_own(prim.GetAttribute(name.removeprefix(_INVERTED)))
    ]
    place = own[-1] + 1 if own else 0
    return [*order[:place], *missing, *order[place:]]
