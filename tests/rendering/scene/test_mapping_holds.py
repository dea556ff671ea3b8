"""The table of all concepts of USD is true: each is changed alone in a small stage.

What it calls supported changes the scene or a view, what it calls reported is a line of the report
with the prim, and what it calls ignored changes nothing at all.
"""

import collections
import fnmatch
import functools
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.rendering.scene.digest import light_digest
from openrooms_usd.usd import mapping
from openrooms_usd.usd.cameras import read_camera
from openrooms_usd.usd.moments import freeze_time
from openrooms_usd.usd.rendersettings import asked_cameras, asked_purposes, is_set
from tests.opening import open_with
from tests.rendering.scene.conftest import Dark
from tests.rendering.scene.schemas import (
    CAMERA,
    DRAWN,
    GROUND,
    OTHER,
    RIG,
    SECOND,
    Change,
    at,
    elsewhere,
    instance_of,
    refer,
    several,
    shaded,
    small,
    to,
    unbind,
    write_files,
)

State = tuple[Any, ...]
Rows = list[tuple[str, str, str]]
Kind = Sdf.ValueTypeNames
SCHEMAS = mapping.schemas()
LIGHTS = [name for name in SCHEMAS if name.endswith("Light") or name == "DomeLight_1"]
FLAGS = ("disableDepthOfField", "disableMotionBlur", "instantaneousShutter")


# What is rendered of a stage.


def made_of(stage: Usd.Stage, time_code: float | None = None) -> tuple[State, Rows]:
    """All that is rendered, to compare, and the report."""
    lost = freeze_time(stage, time_code)
    opened = open_with(Dark(), stage)
    opened.report.lose(lost)
    scene = opened.scene
    views = [plain(path, read_camera(stage.GetPrimAtPath(path), 40, 30)) for path in opened.cameras]
    flags = [is_set(stage, None, flag) for flag in FLAGS]
    asked = (asked_cameras(stage), opened.resolution, asked_purposes(stage), flags)
    return (light_digest(scene), scene.pieces, scene.legend, views, asked), opened.report.rows


def plain(path: str, camera: object) -> tuple[Any, ...]:
    values = vars(camera).values()
    return path, *(v.tolist() if isinstance(v, np.ndarray) else v for v in values)


def told(rows: Rows, path: object) -> str:
    """What the report says of a prim."""
    return "; ".join(f"{outcome}: {why}" for prim, outcome, why in rows if prim == str(path))


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_files(tmp_path)
    monkeypatch.chdir(tmp_path)


# Types.


def test_every_type_alone_in_a_stage_is_translated_without_a_traceback() -> None:
    for kind in SCHEMAS:
        if Usd.SchemaRegistry().FindConcretePrimDefinition(kind):
            stage = Usd.Stage.CreateInMemory()
            stage.DefinePrim("/It", kind)
            said = told(open_with(Dark(), stage).report.rows, "/It")
            outcome = mapping.rows("types").get(kind, mapping.row_of_type(kind)).outcome
            assert (outcome == "reported") <= ("skipped" in said), kind
            assert (outcome == "ignored") <= (not said), kind


def test_what_the_table_says_of_types_holds() -> None:
    for kind in SCHEMAS:
        row = mapping.row_of_type(kind)
        stage, prim = small(kind)
        place = f"{prim.GetPath()}[0]" if kind == "PointInstancer" else prim.GetPath()
        said = told(made_of(stage)[1], place)
        if row.outcome == "reported" and not row.told_by:
            assert "skipped" in said or row.becomes in said, kind
        elif row.outcome != "reported" and (kind in DRAWN or kind in LIGHTS):
            expected = "translated" if row.outcome == "supported" else "approximated"
            assert said.startswith(expected), f"{kind} {said}"


# Properties.


def cases(outcome: str) -> Iterator[tuple[str, str, mapping.Row]]:
    """(schema, property, its row): each property of each schema that brings it."""
    seen = set()
    for schema in (*TYPICAL, *(name for name in SCHEMAS if name not in TYPICAL)):
        for name in SCHEMAS[schema][1]:
            row = mapping.row_of_property(mapping.lineage(schema), name)
            assert row is not None
            owner, _, _ = row.name.partition(".")
            key = row.name, name, schema if "*" in owner else owner
            if row.outcome == outcome and key not in seen and not found(APART, schema, name):
                seen.add(key)
                yield schema, name, row


# Where properties are tried that many types have.
TYPICAL = ("Cube", "Mesh", "RectLight", "BasisCurves", "RenderSettings")


def nudged(value: Any) -> Any:
    """Another value of the same type."""
    match value:
        case bool():
            return not value
        case int() | float():
            return value + (1 if isinstance(value, int) else 0.25)
        case str():
            return "other"
        case Sdf.AssetPath():
            return Sdf.AssetPath("other.png")
        case Gf.Quatf() | Gf.Quath() | Gf.Quatd():
            return type(value)(0.6, 0.8, 0.0, 0.0)
        case Gf.Matrix4d():
            return Gf.Matrix4d(value).SetTranslateOnly((1, 2, 3))
        case Sdf.PathExpression():
            return Sdf.PathExpression("//Other")
        case Sdf.TimeCode():
            return Sdf.TimeCode(2.0)
        case _:
            return type(value)(*(part + 0.25 for part in value))


def found(table: dict[str, Any], schema: str, name: str) -> Any:
    """What a table has for a property; None for nothing."""
    at = f"{schema}.{name}"
    return next((one for pattern, one in table.items() if fnmatch.fnmatchcase(at, pattern)), None)


def otherwise(prim: Usd.Prim, schema: str, name: str) -> None:
    """Give a property another value than it has."""
    change = found(CHANGES, schema, name)
    if change is not None:
        change(prim)
        return
    name = name.replace("__INSTANCE_NAME__", "".join(instance_of(schema)))
    if prim.GetRelationship(name):
        prim.GetRelationship(name).SetTargets([OTHER])
        return
    attribute = prim.GetAttribute(name)
    assert attribute, f"{prim.GetTypeName()} {name}"
    kind, value = attribute.GetTypeName(), attribute.Get()
    allowed = [str(one) for one in attribute.GetMetadata("allowedTokens") or ()]
    if kind == Kind.Opaque:
        return
    if allowed and not kind.isArray:
        attribute.Set(next(one for one in allowed if one != value))
    elif kind.isArray:
        one = kind.scalarType.defaultValue
        attribute.Set([nudged(part) for part in (value or [one, one])])
    else:
        attribute.Set(nudged(kind.defaultValue if value is None else value))


_CATMULL_CLARK = to("subdivisionScheme", "catmullClark")
_CREASED = several(
    _CATMULL_CLARK,
    to("creaseIndices", [1, 2, 3, 0]),
    to("creaseLengths", [2, 2]),
    to("creaseSharpnesses", [2.0, 2.0]),
)
_MOVING = at(0, "positions", [(0, 0, 1), (4, 0, 1)])
_SPUN = several(
    _MOVING, to("positions", [(0, 0, 1), (4, 0, 1)]), at(0, "orientations", [Gf.Quath(1)] * 2)
)
_BLACKBODY = to("inputs:enableColorTemperature", True)
_LINKED = several(
    to("collection:lightLink:includeRoot", False),
    refer("collection:lightLink:includes", "/World/Lit"),
)


def _st(prim: Usd.Prim) -> None:
    primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(
        "st", Kind.TexCoord2fArray, UsdGeom.Tokens.faceVarying
    )
    primvar.Set([(0, 0), (1, 0), (1, 1), (0, 1), (0.2, 1), (1, 1), (0.3, 2)])


def _posed(prim: Usd.Prim) -> None:
    """Only its first joint is animated."""
    elsewhere(f"{RIG}/Animation", to("joints", ["a"]))(prim)
    for name, value in (
        ("translations", [(0, 0, 1)]),
        ("rotations", [Gf.Quatf(1)]),
        ("scales", [Gf.Vec3h(1)]),
    ):
        attribute = prim.GetStage().GetAttributeAtPath(f"{RIG}/Animation.{name}")
        attribute.Clear()
        attribute.Set(value)


def _stilled(name: str, value: Any) -> Change:
    def change(prim: Usd.Prim) -> None:
        prim.GetAttribute(name).Clear()
        prim.GetAttribute(name).Set(value)

    return change


_LAMP = to("inputs:shaping:ies:file", Sdf.AssetPath("other.ies"))
SECOND_PRODUCT = "/World/SecondProduct"


def _other_product(prim: Usd.Prim) -> None:
    refer("camera", CAMERA)(prim.GetStage().DefinePrim(SECOND_PRODUCT, "RenderProduct"))


def settings(stage: Usd.Stage) -> Usd.Prim:
    stage.SetMetadata("renderSettingsPrimPath", "/World/Settings")
    return stage.DefinePrim("/World/Settings", "RenderSettings")


def _displaced(prim: Usd.Prim) -> None:
    shader = UsdShade.Shader.Define(prim.GetStage(), prim.GetPath().AppendChild("Moves"))
    shader.CreateIdAttr("ND_displacement_float")
    output = shader.CreateOutput("out", Kind.Token)
    UsdShade.Material(prim).CreateDisplacementOutput().ConnectToSource(output)


def _lifted(prim: Usd.Prim) -> None:
    shape = UsdGeom.Xformable(prim)
    shape.AddTranslateOp(opSuffix="lifted").Set((1, 2, 3))
    shape.AddRotateXOp(opSuffix="lifted").Set(30.0)


def _sampled(prim: Usd.Prim) -> None:
    """Points have a sample from which velocities may carry them."""
    points = UsdGeom.PointBased(prim).GetPointsAttr()
    points.Set(points.Get(), 0.0)


def _each(name: str, *times: float) -> Change:
    """A change that gives every point an upward vector."""

    def change(prim: Usd.Prim) -> None:
        size = len(UsdGeom.PointBased(prim).GetPointsAttr().Get())
        for time in times or (Usd.TimeCode.Default(),):
            prim.GetAttribute(name).Set([(0, 0, 1)] * size, time)

    return change


def _halved(prim: Usd.Prim) -> None:
    """Two curves of one."""
    size = prim.GetAttribute("curveVertexCounts").Get()[0]
    prim.GetAttribute("curveVertexCounts").Set([size - size // 2, size // 2])


# What must be there for a property to count: "schema.property".
CONTEXTS: dict[str, Change] = {
    "*.primvars:display*": unbind,
    "SphereLight.treatAsPoint": to("inputs:radius", 0.0),
    "CylinderLight.treatAsLine": to("inputs:radius", 0.0),
    "ShapingAPI.*focusTint": to("inputs:shaping:focus", 2.0),
    "PointInstancer.velocities": _MOVING,
    "PointInstancer.accelerations": several(_MOVING, at(0, "velocities", [(0, 0, 1)] * 2)),
    "*.velocities": _sampled,
    "*.accelerations": several(_sampled, _each("velocities", 0.0)),
    "Mesh.creaseSharpnesses": several(_CREASED, to("creaseIndices", [2, 3, 0, 1])),
    "Mesh.crease*": _CREASED,
    "Mesh.corner*": several(
        _CATMULL_CLARK, to("cornerIndices", [2]), to("cornerSharpnesses", [1.0])
    ),
    "Mesh.interpolateBoundary": _CATMULL_CLARK,
    "Mesh.triangleSubdivisionRule": _CATMULL_CLARK,
    "Mesh.faceVaryingLinearInterpolation": several(_CATMULL_CLARK, _st),
    "BasisCurves.curveVertexCounts": to("type", "linear"),
    "BasisCurves.wrap": to("basis", "bspline"),
    "PointInstancer.angularVelocities": _SPUN,
    "PointInstancer.ids": to("invisibleIds", [0]),
    "Camera.verticalAperture": lambda prim: (
        settings(prim.GetStage())
        .GetAttribute("aspectRatioConformPolicy")
        .Set("adjustApertureWidth")
    ),
    "Camera.fStop": to("focusDistance", 2.0),
    "Camera.shutter:open": to("shutter:close", 1.0),
    "*.inputs:colorTemperature": _BLACKBODY,
    "*.inputs:enableColorTemperature": to("inputs:colorTemperature", 3000.0),
    "RectLight.inputs:normalize": to("inputs:width", 2.0),
    "*.collection:lightLink:membershipE*": to("collection:lightLink:includeRoot", False),
    "*.collection:shadowLink:membershipE*": to("collection:shadowLink:includeRoot", False),
    "*.collection:lightLink:*": _LINKED,
    "*.light:materialSyncMode": shaded("emissiveColor", (1.0, 0.5, 0.2), Kind.Color3f),
    "ShapingAPI.*softness": to("inputs:shaping:cone:angle", 30.0),
    "DomeLight*.inputs:texture:format": to("inputs:texture:file", Sdf.AssetPath("other.png")),
    "RenderSettings.products": _other_product,
    "RenderProduct.aspect*": refer("camera", CAMERA),
    "ShapingAPI.*ies:angleScale": _LAMP,
    "ShapingAPI.*ies:normalize": _LAMP,
    "BlendShape.normalOffsets": elsewhere(f"{RIG}/Mesh", to("normals", [(0, -1, 0)] * 6)),
    "Skeleton.restTransforms": _posed,
}
# Other values, where any would not do.
CHANGES: dict[str, Change] = {
    "*.purpose": to("purpose", "guide"),
    "*.visibility": to("visibility", "invisible"),
    "*.xformOpOrder": _lifted,
    "NurbsCurves.curveVertexCounts": several(
        to("curveVertexCounts", [3, 2]),
        to("order", [2, 2]),
        to("knots", [0, 0, 1, 2, 2, 0, 0, 1, 1]),
    ),
    "*.curveVertexCounts": _halved,
    "BasisCurves.wrap": to("wrap", "periodic"),
    "PointInstancer.velocities": at(0, "velocities", [(0, 0, 1)] * 2),
    "PointInstancer.accelerations": at(0, "accelerations", [(0, 0, 1)] * 2),
    **{f"*.{name}": _each(name, 0.0) for name in ("velocities", "accelerations")},
    "*.normals": _each("normals"),
    "Mesh.faceVertexCounts": to("faceVertexCounts", [3, 4]),
    "Mesh.faceVertexIndices": to("faceVertexIndices", [0, 1, 2, 3, 3, 2, 1]),
    "Mesh.creaseIndices": to("creaseIndices", [2, 3, 1, 0]),
    "Mesh.creaseLengths": several(to("creaseLengths", [4]), to("creaseSharpnesses", [2.0])),
    "Mesh.creaseSharpnesses": to("creaseSharpnesses", [1.0, 1.0]),
    "Mesh.cornerIndices": to("cornerIndices", [3]),
    "Mesh.cornerSharpnesses": to("cornerSharpnesses", [2.0]),
    "Mesh.interpolateBoundary": to("interpolateBoundary", "edgeOnly"),
    "Mesh.holeIndices": to("holeIndices", [1]),
    "NurbsCurves.order": several(to("order", [3]), to("knots", [0, 0, 0, 1, 2, 3, 3, 3])),
    "NurbsCurves.knots": to("knots", [0, 0, 0, 0, 1.5, 2, 2, 2, 2]),
    "NurbsCurves.ranges": to("ranges", [(0.5, 1.5)]),
    "NurbsCurves.pointWeights": to("pointWeights", [1, 2, 1, 1, 1]),
    "NurbsPatch.pointWeights": to("pointWeights", [1.0] * 15 + [2.0]),
    "NurbsPatch.uOrder": several(to("uOrder", 3), to("uKnots", [0, 0, 0, 1, 2, 2, 2])),
    "NurbsPatch.vOrder": several(to("vOrder", 3), to("vKnots", [0, 0, 0, 1, 2, 2, 2])),
    "NurbsPatch.?VertexCount": several(
        to("uVertexCount", 2),
        to("uOrder", 2),
        to("uKnots", [0, 0, 1, 1]),
        to("vVertexCount", 8),
        to("vKnots", [0, 0, 0, 0, 1, 2, 3, 4, 5, 5, 5, 5]),
    ),
    "NurbsPatch.uRange": to("uRange", (0.2, 0.8)),
    "NurbsPatch.vRange": to("vRange", (0.2, 0.8)),
    "NurbsPatch.trimCurve:*": to("trimCurve:counts", [1]),
    "PointInstancer.prototypes": refer("prototypes", OTHER, GROUND),
    "PointInstancer.protoIndices": to("protoIndices", [1, 0]),
    "PointInstancer.ids": to("ids", [5, 0]),
    "PointInstancer.invisibleIds": to("invisibleIds", [1]),
    "PointInstancer.angularVelocities": at(0, "angularVelocities", [(0, 0, 1)] * 2),
    "TetMesh.tetVertexIndices": to("tetVertexIndices", [(0, 1, 3, 2)]),
    "TetMesh.surfaceFaceVertexIndices": to("surfaceFaceVertexIndices", [(0, 1, 2)]),
    "GeomSubset.indices": to("indices", [1]),
    "Camera.verticalAperture": to("verticalAperture", 10.0),
    "Camera.clippingRange": to("clippingRange", (2.0, 50.0)),
    "Material.outputs:surface": lambda prim: prim.GetAttribute("outputs:surface").SetConnections(
        [f"{SECOND}/Surface.outputs:surface"]
    ),
    "Material.outputs:displacement": _displaced,
    "*.collection:lightLink:includes": refer("collection:lightLink:includes", OTHER),
    "*.collection:lightLink:excludes": refer("collection:lightLink:excludes", GROUND),
    "MeshLightAPI.light:materialSyncMode": to("light:materialSyncMode", "noMaterialResponse"),
    "*.light:materialSyncMode": to("light:materialSyncMode", "materialGlowTintsLight"),
    "DomeLight_1.poleAxis": to("poleAxis", "Y"),
    "RenderSettings.resolution": to("resolution", Gf.Vec2i(20, 10)),
    "RenderProduct.resolution": to("resolution", Gf.Vec2i(20, 10)),
    "*.aspectRatioConformPolicy": to("aspectRatioConformPolicy", "adjustApertureWidth"),
    "*.camera": refer("camera", CAMERA),
    "Skeleton.restTransforms": to("restTransforms", [Gf.Matrix4d(1), Gf.Matrix4d(2)]),
    "SkelAnimation.translations": _stilled("translations", [(0, 0, 1), (1, 0, 1)]),
    "SkelAnimation.rotations": _stilled("rotations", [Gf.Quatf(1), Gf.Quatf(0.6, 0.8, 0, 0)]),
    "SkelAnimation.blendShapeWeights": _stilled("blendShapeWeights", [0.1]),
    "BlendShape.pointIndices": to("pointIndices", [5, 4, 3, 2, 1, 0]),
    "SkelBindingAPI.skel:animationSource": elsewhere(
        f"{RIG}/Skeleton", refer("skel:animationSource", OTHER)
    ),
    "BlendShape.normalOffsets": to("normalOffsets", [(0, 0, 3)] * 6),
    "DomeLight*.inputs:texture:format": to("inputs:texture:format", "angular"),
    "RenderSettings.products": refer("products", SECOND_PRODUCT),
    "ShapingAPI.*ies:file": _LAMP,
    "SemanticsLabelsAPI.*": to(f"semantics:labels:{names.CATEGORY}", ["chair"]),
    "SpatialAudio.xformOpOrder": _lifted,
    "SkelBindingAPI.*jointIndices": to("primvars:skel:jointIndices", [1, 0] * 6),
}
# What has no value of its own, or is shown in other tests.
APART = {
    "*.doubleSided": "of panes of glass: tests/mitsuba/test_panes.py",
    "*.collection:*Link": "a collection as a whole has no value",
    "*.collection:*Link:mode": "it says which of the others count",
    "CollectionAPI.*": "collections count for those who refer to them: lights",
    "RenderProduct.orderedVars": "channels are asked for: tests/usd/test_rendersettings.py",
    "RenderVar.sourceName": "tests/usd/test_rendersettings.py",
}


def tried(schema: str, *changed: str, beside: str = "") -> tuple[State, Rows, str]:
    """What is rendered once properties are changed, the report, and the path of the prim.

    Args:
        schema: Of which a stage has a prim.
        changed: What is changed.
        beside: The property whose context there is.
    """
    stage, prim = small(schema)
    (found(CONTEXTS, schema, beside) or several())(prim)
    for name in changed:
        otherwise(prim, schema, name)
    return *made_of(stage, 5.0), str(prim.GetPath())


def without_effect(every: Iterable[tuple[str, str]]) -> list[str]:
    """What changes nothing of what is rendered, or makes the prim be left out."""
    failed = []
    as_it_is = functools.cache(tried)
    for schema, name in every:
        beside = name if found(CONTEXTS, schema, name) else ""
        before, rows, path = as_it_is(schema, beside=beside)
        after, later, _ = tried(schema, name, beside=name)
        if before == after:
            failed.append(f"{schema}.{name}: nothing changes")
        lost = "skipped" in told(later, path) and "skipped" not in told(rows, path)
        if lost and name not in ("visibility", "purpose"):
            failed.append(f"{schema}.{name}: {told(later, path)}")
    return failed


@pytest.mark.parametrize("module", sorted({SCHEMAS[one][0] for one, _, _ in cases("supported")}))
def test_what_is_supported_changes_the_scene_or_a_view(module: str) -> None:
    every = [(one, name) for one, name, _ in cases("supported") if SCHEMAS[one][0] == module]
    failed = without_effect(every)
    assert failed == [], "\n".join(failed)


@pytest.mark.slow
def test_what_is_supported_does_so_for_every_type_that_inherits_it() -> None:
    every = [
        (schema, name)
        for schema, (_, properties) in SCHEMAS.items()
        for name in properties
        if mapping.row_of_property(mapping.lineage(schema), name).outcome == "supported"
        if not found(APART, schema, name)
    ]
    assert len(every) > 300
    failed = without_effect(every)
    assert failed == [], "\n".join(failed)


def test_what_is_approximated_changes_something_or_is_told() -> None:
    for schema, name, _ in cases("approximated"):
        before, rows, _ = tried(schema, beside=name)
        after, later, _ = tried(schema, name, beside=name)
        assert before != after or rows != later, f"{schema}.{name}"


def test_what_is_reported_is_a_line_with_the_prim() -> None:
    failed = []
    for schema, name, row in cases("reported"):
        # Of what is reported as a whole one property is as good as another.
        if row.told_by in SCHEMAS and name != SCHEMAS[schema][1][0]:
            continue
        after, rows, path = tried(schema, name, beside=name)
        if row.is_told_here and after != tried(schema, beside=name)[0]:
            failed.append(f"{schema}.{name}: it is in the picture")
        said = told(rows, path) or " ".join(why for _, _, why in rows if path in why)
        if not said.replace("translated: ", "") or (row.is_told_here and name not in said):
            failed.append(f"{schema}.{name}: {said}")
    assert failed == [], "\n".join(failed)


def test_what_is_ignored_changes_nothing() -> None:
    failed = []
    names = collections.defaultdict(list)
    for schema, name, _ in cases("ignored"):
        names[schema].append(name)
    for schema, every in names.items():
        before, rows, path = tried(schema)
        after, later, _ = tried(schema, *every)
        if before != after or rows != later:
            failed.append(f"one of {schema}'s {every}: {told(later, path)}")
    assert failed == [], "\n".join(failed)
