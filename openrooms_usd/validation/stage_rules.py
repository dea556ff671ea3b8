"""USD's own validators, and our rules about prims, layers, bodies and joints."""

import re
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from pxr import Kind, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, UsdValidation, Vt

from openrooms_usd import names
from openrooms_usd.edits.orphans import find_orphans
from openrooms_usd.usd.cameras import list_cameras
from openrooms_usd.usd.doubts import camera_doubts, light_doubts
from openrooms_usd.usd.files.diagnostics import UNREADABLE, plain, reason
from openrooms_usd.usd.files.layers import prim_specs
from openrooms_usd.usd.light.inputs import old_names
from openrooms_usd.usd.light.lights import read_lights
from openrooms_usd.usd.places.metrics import find_unit_mismatches
from openrooms_usd.validation.model import (
    Complaint,
    Finding,
    Severity,
    Subject,
    has_label,
    has_material,
)

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
            yield (str(prim.GetPath()), "neither it nor a prim above it has a semantic label")


def kinds(subject: Subject) -> Iterator[Complaint]:
    """The default prim is a model, and models stand in groups without a gap."""
    top = subject.stage.GetDefaultPrim()
    if top and not Usd.ModelAPI(top).GetKind():
        yield str(top.GetPath()), "the default prim has no kind"
    for prim in subject.prims:
        kind = Usd.ModelAPI(prim).GetKind()
        if kind and Kind.Registry.IsA(kind, Kind.Tokens.model) and not prim.IsModel():
            yield str(prim.GetPath()), f"a {kind} below a prim that is not a group"


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


# Rules about layers: what each may say, and how they fit together.

# USD takes these from the root layer alone, so a layer that differs shows something else by itself.
METADATA: Final = (
    "defaultPrim",
    UsdGeom.Tokens.upAxis,
    UsdGeom.Tokens.metersPerUnit,
    "kilogramsPerUnit",
)

_ELSEWHERE = re.compile(r"[/\\]|[A-Za-z]:[/\\]|[A-Za-z][A-Za-z0-9+.-]+:")
# An expression, in backticks, says where the file is only when it is evaluated.
_ANCHORED = re.compile(r"\.{1,2}/|`")


def equal_metadata(subject: Subject) -> Iterator[Complaint]:
    """Every layer of the stack has the root layer's axis, units and default prim."""
    for layer in subject.stack[1:]:
        for key in METADATA:
            here, there = _metadata(layer, key), _metadata(subject.root, key)
            if here != there:
                yield subject.name(layer), f"{key} is {here}, the root layer says {there}"


def _metadata(layer: Sdf.Layer, key: str) -> object:
    root = layer.pseudoRoot
    return root.GetInfo(key) if root.HasInfo(key) else "missing"


def absolute_paths(subject: Subject) -> Iterator[Complaint]:
    """No layer names a file by a place on one machine."""
    for layer, path in subject.asset_paths:
        if _ELSEWHERE.match(path):
            yield subject.name(layer), f"@{path}@ is an absolute path"


def unanchored_paths(subject: Subject) -> Iterator[Complaint]:
    """Every file is named from the layer that names it, and not from a search path."""
    for layer, path in subject.asset_paths:
        if path and not _ELSEWHERE.match(path) and not _ANCHORED.match(path):
            yield subject.name(layer), f"@{path}@ does not start with ./ or ../"


def one_definer(subject: Subject) -> Iterator[Complaint]:
    """A prim is defined by one layer; the others only write over it."""
    definer: dict[Sdf.Path, Sdf.Layer] = {}
    for layer in subject.stack:
        for spec in prim_specs(layer):
            if spec.specifier == Sdf.SpecifierOver:
                continue
            first = definer.setdefault(spec.path, layer)
            if first is not layer:
                yield (
                    str(spec.path),
                    f"defined by {subject.name(first)} and by {subject.name(layer)}",
                )


def nothing_below_instances(subject: Subject) -> Iterator[Complaint]:
    """No layer writes below an instance, where USD drops it without a word."""
    for layer in subject.stack:
        for spec in prim_specs(layer):
            parent = subject.stage.GetPrimAtPath(spec.path.GetParentPath())
            if parent and parent.IsInstance() and not parent.IsInstanceProxy():
                yield str(spec.path), f"{subject.name(layer)} writes below an instance: it is lost"


def no_orphans(subject: Subject) -> Iterator[Complaint]:
    """Every opinion finds what it speaks about; `nothing_below_instances` sees to instances."""
    for layer in subject.stack:
        for orphan in find_orphans(subject.stage, [layer]):
            if orphan.reason != "instance":
                near = f"; near: {orphan.hint}" if orphan.hint else ""
                yield orphan.path, f"{subject.name(layer)} {orphan.message}{near}"


def plausible(subject: Subject) -> Iterator[Complaint]:
    """Cameras and lights have plausible values."""
    for prim in list_cameras(subject.stage):
        yield from ((str(prim.GetPath()), doubt) for doubt in camera_doubts(prim))
    for light in read_lights(subject.stage):
        yield from ((light.path, doubt) for doubt in light_doubts(light))
        if old := old_names(subject.stage.GetPrimAtPath(light.path)):
            yield light.path, f"USD ignores these names of before 21.02: {', '.join(old)}"


def referenced_units(subject: Subject) -> Iterator[Complaint]:
    """What is referred to has the stage's units and up axis, or operations that correct it."""
    for misfit in find_unit_mismatches(subject.stage):
        yield misfit.path, misfit.said


# USD's own validators, all of them, as findings.

_SEVERITY: Final[dict[UsdValidation.ValidationErrorType, Severity]] = {
    UsdValidation.ValidationErrorType.Error: "error",
    UsdValidation.ValidationErrorType.Warn: "warning",
}


def core_findings(subject: Subject) -> Iterator[Finding]:
    """Run every registered validator on a stage; what instances share is looked at once."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    try:
        yield from _run(subject, validators)
    except UNREADABLE:
        # One that throws hides what the others found: a broken layer does it.
        for validator in validators:
            try:
                yield from _run(subject, [validator])
            except UNREADABLE as error:
                name = validator.GetMetadata().name
                yield Finding("error", name, subject.name(subject.root), reason(error))


def _run(subject: Subject, validators: Sequence[UsdValidation.Validator]) -> list[Finding]:
    context = UsdValidation.ValidationContext(validators)
    errors = list(context.Validate(subject.stage, Usd.PrimDefaultPredicate))
    shared = [prim for prim in subject.prims if prim.IsInstanceProxy()]
    if shared:
        errors += context.Validate(shared)
    return [
        Finding(severity, error.GetIdentifier(), _place(subject, error), _text(subject, error))
        for error in errors
        if (severity := _SEVERITY.get(error.GetType())) and not _is_materialx(error)
    ]


def _is_materialx(error: UsdValidation.ValidationError) -> bool:
    """Whether it says that a MaterialX node is unknown: this USD has no MaterialX."""
    if not error.GetIdentifier().endswith("ShaderSdrCompliance.MissingShaderIdInRegistry"):
        return False
    return any(
        str(UsdShade.Shader(site.GetProperty().GetPrim()).GetIdAttr().Get()).startswith("ND_")
        for site in error.GetSites()
        if site.IsProperty()
    )


def _place(subject: Subject, error: UsdValidation.ValidationError) -> str:
    for site in error.GetSites():
        if site.IsProperty():
            return str(site.GetProperty().GetPath())
        if site.IsPrim() and site.GetPrim().GetPath() != Sdf.Path.absoluteRootPath:
            return str(site.GetPrim().GetPath())
        if site.GetLayer():
            return subject.name(site.GetLayer())
    return subject.name(subject.root)


def _text(subject: Subject, error: UsdValidation.ValidationError) -> str:
    return plain(error.GetMessage()).replace(subject.home, "./")


# Rules about bodies and joints that engines refuse rooms for, beside those of USD's validators.


def nested_bodies(subject: Subject) -> Iterator[Complaint]:
    """No body that moves lies below another one, unless it leaves its parent's transform."""
    for prim in subject.prims:
        if moves(prim) and (outer := _outer(prim)):
            yield str(prim.GetPath()), f"a rigid body below the rigid body {outer.GetPath()}"


def _outer(body: Usd.Prim) -> Usd.Prim | None:
    prim = body
    while prim and not UsdGeom.Xformable(prim).GetResetXformStack():
        prim = prim.GetParent()
        if prim and moves(prim):
            return prim
    return None


def articulations(subject: Subject) -> Iterator[Complaint]:
    """Bodies that joints hold to each other are in an articulation; joints to the world need none.

    Its root stands on one of the bodies or joints, or above one.
    """
    group: dict[Sdf.Path, Sdf.Path] = {}
    joints: dict[Sdf.Path, Sdf.Path] = {}
    for prim in subject.prims:
        ends = _joined(prim)
        if len(ends) == 2:
            joints[prim.GetPath()] = ends[0]
            group[_top(group, ends[0])] = _top(group, ends[1])
    rooted = {
        _top(group, body)
        for joint, body in joints.items()
        if any(_has_root(subject.stage.GetPrimAtPath(path)) for path in (joint, body))
    }
    rooted |= {_top(group, body) for body in group if _has_root(subject.stage.GetPrimAtPath(body))}
    for joint, body in joints.items():
        if _top(group, body) not in rooted:
            yield str(joint), "joins two bodies that belong to no articulation"


def _joined(prim: Usd.Prim) -> list[Sdf.Path]:
    """The distinct bodies that move which a joint holds together, first what holds."""
    joint = UsdPhysics.Joint(prim)
    if not joint or not joint.GetJointEnabledAttr().Get():
        return []
    if joint.GetExcludeFromArticulationAttr().Get():
        return []
    found: dict[Sdf.Path, None] = {}
    for relation in (joint.GetBody0Rel(), joint.GetBody1Rel()):
        for target in relation.GetTargets()[:1]:
            body = prim.GetStage().GetPrimAtPath(target)
            while body and not moves(body):
                body = body.GetParent()
            if body:
                found[body.GetPath()] = None
    return list(found)


def moves(prim: Usd.Prim) -> bool:
    """Whether a prim is a body that forces move: enabled and not kinematic."""
    body = UsdPhysics.RigidBodyAPI(prim) if prim.HasAPI(UsdPhysics.RigidBodyAPI) else None
    if body is None or not body.GetRigidBodyEnabledAttr().Get():
        return False
    return not body.GetKinematicEnabledAttr().Get()


def _has_root(prim: Usd.Prim) -> bool:
    while prim and not prim.IsPseudoRoot():
        if prim.HasAPI(UsdPhysics.ArticulationRootAPI):
            return True
        prim = prim.GetParent()
    return False


def _top(group: dict[Sdf.Path, Sdf.Path], body: Sdf.Path) -> Sdf.Path:
    while (above := group.setdefault(body, body)) != body:
        body = above
    return body
