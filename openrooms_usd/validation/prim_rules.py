"""Rules about prims: what geometry must say of itself, models, and the names of our scenes."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from pxr import Kind, Usd, UsdGeom, UsdShade, Vt

from openrooms_usd import names
from openrooms_usd.validation.model import Complaint, Subject, has_label, has_material

# (path, type, kind) of the prims that other tools look for in our scenes; None: any.
CONTRACT: Final = (
    (names.WORLD, "Xform", Kind.Tokens.assembly),
    (names.ROOM, "Xform", Kind.Tokens.component),
    (names.FLOOR, "Mesh", None),
    (names.CEILING, "Mesh", None),
    (names.FURNITURE, "Xform", Kind.Tokens.group),
    (names.MATERIALS, "Scope", None),
    (names.LIGHTS, "Scope", None),
    (names.CAMERAS, "Scope", None),
    (names.RENDER, "Scope", None),
    (names.RENDER_SETTINGS, "RenderSettings", None),
)

# Where it moves, geometry is looked at where it starts.
_START: Final = Usd.TimeCode.EarliestTime()

# Extents are float32: they may be this much too small, as a fraction of the largest coordinate.
_EXTENT_TOLERANCE: Final = 1e-5


def extents(subject: Subject) -> Iterator[Complaint]:
    """All geometry has an extent, and its points lie within."""
    for prim in subject.gprims:
        boundable = UsdGeom.Boundable(prim)
        attribute = boundable.GetExtentAttr()
        extent = attribute.Get(_START) if attribute.HasAuthoredValue() else None
        if extent is None or len(extent) != 2:
            yield str(prim.GetPath()), "has no extent"
        elif not _encloses(extent, boundable):
            yield str(prim.GetPath()), "its extent does not enclose it"


def _encloses(extent: Vt.Vec3fArray, boundable: UsdGeom.Boundable) -> bool:
    actual = UsdGeom.Boundable.ComputeExtentFromPlugins(boundable, _START)
    if actual is None or len(actual) != 2:
        return True  # nothing to enclose
    authored, wanted = np.array(extent, float), np.array(actual, float)
    slack = _EXTENT_TOLERANCE * max(1.0, float(np.abs(wanted).max()))
    return bool(
        (authored[0] <= wanted[0] + slack).all() and (authored[1] >= wanted[1] - slack).all()
    )


def subdivision_schemes(subject: Subject) -> Iterator[Complaint]:
    """All meshes say how they are subdivided; the default is not what most mean."""
    for prim in subject.gprims:
        if prim.IsA(UsdGeom.Mesh) and not prim.GetAttribute("subdivisionScheme").HasAuthoredValue():
            yield str(prim.GetPath()), "subdivisionScheme is not authored: it means catmullClark"


def materials(subject: Subject) -> Iterator[Complaint]:
    """All geometry has a material, on itself or on all of its faces."""
    for prim in subject.gprims:
        if not has_material(prim) and not _bound_by_subsets(prim):
            yield str(prim.GetPath()), "no material is bound to it"


def _bound_by_subsets(prim: Usd.Prim) -> bool:
    family = UsdShade.Tokens.materialBind
    subsets = UsdGeom.Subset.GetGeomSubsets(UsdGeom.Imageable(prim), UsdGeom.Tokens.face, family)
    if not subsets or not all(has_material(subset.GetPrim()) for subset in subsets):
        return False
    counts = UsdGeom.Mesh(prim).GetFaceVertexCountsAttr().Get() if prim.IsA(UsdGeom.Mesh) else None
    left = UsdGeom.Subset.GetUnassignedIndices(subsets, len(counts)) if counts else ()
    return len(left) == 0


def labels(subject: Subject) -> Iterator[Complaint]:
    """All geometry says what it is, or what it is a part of."""
    for prim in subject.gprims:
        if not has_label(prim):
            yield (
                str(prim.GetPath()),
                f"neither it nor a prim above it has a {names.CATEGORY} label",
            )


def kinds(subject: Subject) -> Iterator[Complaint]:
    """The default prim is a model, and models stand in groups without a gap."""
    top = subject.stage.GetDefaultPrim()
    if top and not Usd.ModelAPI(top).GetKind():
        yield str(top.GetPath()), "the default prim has no kind"
    for prim in subject.prims:
        kind = Usd.ModelAPI(prim).GetKind()
        if kind and Kind.Registry.IsA(kind, Kind.Tokens.model) and not prim.IsModel():
            yield str(prim.GetPath()), f"a {kind} below a prim that is no group"


def components(subject: Subject) -> Iterator[Complaint]:
    """A published component has a class, for edits of all its copies, and an extents hint."""
    for prim in subject.prims:
        if not prim.HasAuthoredReferences() or not Usd.ModelAPI(prim).IsKind(Kind.Tokens.component):
            continue
        if not prim.HasAuthoredInherits():
            yield str(prim.GetPath()), "the component inherits no class"
        if UsdGeom.ModelAPI(prim).GetExtentsHint() is None:
            yield str(prim.GetPath()), "the component has no extentsHint"


def contract(subject: Subject) -> Iterator[Complaint]:
    """In our own scenes, other tools find what they look for where the names say."""
    if not subject.ours:
        return
    for path, type_name, kind in CONTRACT:
        prim = subject.stage.GetPrimAtPath(path)
        if not prim or not prim.IsDefined():
            continue
        if prim.GetTypeName() != type_name:
            yield path, f"is a {prim.GetTypeName() or 'prim without type'}, not a {type_name}"
        if kind and Usd.ModelAPI(prim).GetKind() != kind:
            yield path, f"its kind is {Usd.ModelAPI(prim).GetKind() or 'missing'}, not {kind}"
    for prim in subject.stage.GetPseudoRoot().GetChildren():
        if str(prim.GetPath()) not in (names.WORLD, names.RENDER):
            yield str(prim.GetPath()), f"stands beside {names.WORLD} and {names.RENDER}"
