"""Names the prims and authored properties of a stage that the picture does not show, and why."""

from collections.abc import Iterator, Sequence
from typing import Any, Final

from pxr import Sdf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd.exporters import Report
from openrooms_usd.usd import mapping
from openrooms_usd.usd.doubts import DOUBT
from openrooms_usd.usd.files.strayed import MISSING
from openrooms_usd.usd.light.inputs import OLD
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.rendersettings import asked_purposes
from openrooms_usd.usd.semantics import LABEL, unread_labels
from openrooms_usd.usd.shading.materialreader import unmoved_by
from openrooms_usd.usd.shading.materials import broken_bindings
from openrooms_usd.usd.shading.textures import UNREADABLE

_PURPOSE: Final = "its purpose is"
# Point instancers may take prototypes that are mere overs or classes.
_PROTOTYPES: Final = Usd.PrimIsActive & Usd.PrimIsLoaded
_ALARMING: Final = (LABEL, OLD, MISSING, UNREADABLE, DOUBT)


def report_unseen(stage: Usd.Stage, report: Report) -> None:
    """Report for each prim what a picture should show but does not, if not reported yet.

    Args:
        stage: The composed stage.
        report: Rows of what was translated; more are added.
    """
    known = {path for path, _, _ in report.rows}
    every = list(_every(stage))
    aside = [target for prim, _ in every for target in _scattered(prim)]
    for prim, place in every:
        if place not in known and (reason := _hidden(prim, aside)):
            report.add(place, "skipped", reason)
    report.lose({place: "; ".join(lost) for prim, place in every if (lost := [*_losses(prim)])})


def is_aside(reason: str) -> bool:
    """Whether a prim is left out for its purpose: no picture lacks what only aids other uses."""
    return reason.startswith(_PURPOSE)


def is_alarming(sentence: str) -> bool:
    """Whether a loss is likely a mistake, to be reported at once."""
    return any(mark in sentence for mark in _ALARMING)


# Prims.


def _every(stage: Usd.Stage) -> Iterator[tuple[Usd.Prim, str]]:
    """Every prim and where it stands: inside instances that of the first, and once.

    What only point instancers show is among them, though it be an over or a class.
    """
    homes: dict[str, str] = {}
    roots = [stage.GetPseudoRoot(), *stage.GetPrototypes()]
    waiting = [iter(Usd.PrimRange(root)) for root in roots]
    met: set[Sdf.Path] = set()
    while waiting:
        for prim in waiting.pop(0):
            if prim.GetPath() in met or prim.IsPseudoRoot():
                continue
            met.add(prim.GetPath())
            yield prim, _standing(prim, homes)
            prototypes = map(stage.GetPrimAtPath, _scattered(prim))
            waiting += [iter(Usd.PrimRange(one, _PROTOTYPES)) for one in prototypes if one]


def _scattered(prim: Usd.Prim) -> list[Sdf.Path]:
    """The prototypes of a point instancer; none of anything else."""
    if not prim.IsA(UsdGeom.PointInstancer):
        return []
    return list(UsdGeom.PointInstancer(prim).GetPrototypesRel().GetForwardedTargets())


def _hidden(prim: Usd.Prim, aside: Sequence[Sdf.Path]) -> str:
    """Why a prim is in no picture; of what may be there it is asked where it stands alone."""
    if prim.IsA(UsdGeom.Gprim) or prim.HasAPI(UsdLux.LightAPI):
        shared = prim.IsInPrototype() or any(map(prim.GetPath().HasPrefix, aside))
        return "" if shared else _why(prim)
    return _foreign(str(prim.GetTypeName()))


def _foreign(kind: str) -> str:
    """Why a type is in no picture; empty for what shapes others, or belongs to other uses."""
    row = mapping.row_of_type(kind)
    if row is None:
        return f"{kind} does not appear in a picture" if kind else ""
    return f"{kind}: {row.becomes}" if row.outcome == "reported" else ""


def _why(prim: Usd.Prim) -> str:
    shown = UsdGeom.Imageable(prim)
    if shown and shown.ComputeVisibility(TIME) == UsdGeom.Tokens.invisible:
        return "invisible"
    purpose = shown.ComputePurpose() if shown else UsdGeom.Tokens.default_
    if purpose not in asked_purposes(prim.GetStage()):
        return f"{_PURPOSE} {purpose}"
    return f"{prim.GetTypeName() or 'it'} has nothing to draw"


# Their authored values.


def _losses(prim: Usd.Prim) -> Iterator[str]:
    applied = prim.GetAppliedSchemas()
    for api in applied:
        row = mapping.row_of_type(api.partition(":")[0])
        if row is not None and row.is_told_here:
            yield f"{api}: {row.becomes}"
    for name in sorted(mapping.told_of().intersection(prim.GetAuthoredPropertyNames())):
        schemas = mapping.lineage(str(prim.GetTypeName()), tuple(applied))
        row = mapping.row_of_property(schemas, name)
        if row is not None and row.is_told_here and _says_something(prim.GetAttribute(name)):
            yield f"{name}: {row.becomes}"
    yield from unread_labels(prim)
    for target in broken_bindings(prim):
        yield f"its material {MISSING}: there is none at {target}"
    if prim.IsA(UsdGeom.Subset) and (lost := _colourless(UsdGeom.Subset(prim))):
        yield lost
    if prim.IsA(UsdShade.Material) and (name := unmoved_by(UsdShade.Material(prim))):
        yield f"{name}: nothing is moved"


def _says_something(attribute: Usd.Attribute) -> bool:
    """Whether an attribute has an authored value other than its fallback."""
    if attribute.HasAuthoredConnections():
        return True
    name, value = attribute.GetName(), attribute.Get(TIME)
    usual = attribute.GetPrim().GetPrimDefinition().GetAttributeFallbackValue(name)
    empty = hasattr(value, "__len__") and not len(value)
    return not (value is None or empty or value == usual or value in mapping.neutral(name))


def _colourless(subset: UsdGeom.Subset) -> str:
    """Why the material of a subset is not shown; empty where it is, or where there is none."""
    prim: Any = subset.GetPrim()
    if subset.GetFamilyNameAttr().Get() != UsdShade.Tokens.materialBind:
        return ""
    element = subset.GetElementTypeAttr().Get()
    if prim.GetParent().IsA(UsdGeom.Mesh) and element == UsdGeom.Tokens.face:
        return ""
    return f"its material is left out: it has {element}s of a {prim.GetParent().GetTypeName()}"


def _home(prototype: Usd.Prim, known: dict[str, str]) -> str:
    """Where a prototype stands in the stage: the first of its instances by the alphabet.

    Args:
        prototype: It.
        known: The homes that have been found; more are added.
    """
    path = str(prototype.GetPath())
    if path not in known:
        every = prototype.GetInstances()
        seen = [one for one in every if not one.IsAbstract()] or every
        known[path] = min(_standing(one, known) for one in seen)
    return known[path]


def _standing(prim: Usd.Prim, known: dict[str, str]) -> str:
    path = prim.GetPath()
    if not prim.IsInPrototype():
        return str(path)
    prototype = prim.GetStage().GetPrimAtPath(path.GetPrefixes()[0])
    return _home(prototype, known) + str(path)[len(str(prototype.GetPath())) :]
