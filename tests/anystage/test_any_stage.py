"""Generated stages, sound and broken: each is a scene that makes sense, or refused in a sentence.

So many stages of each kind as ``ORUSD_STAGES`` says; ``make fuzz`` asks for 2,000.
"""

import os

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd.errors import OrusdError
from openrooms_usd.rendering.scene.arrays import Scene
from tests.anystage.properties import digest, faults, scene_of, views
from tests.anystage.spoil import broken_stage
from tests.anystage.stages import random_stage

STAGES = int(os.environ.get("ORUSD_STAGES", "100"))
BATCH = 25


def batches(count: int = STAGES) -> list[range]:
    return [range(first, min(first + BATCH, count)) for first in range(0, count, BATCH)]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seeds", batches(), ids=lambda seeds: str(seeds[0]))
def test_a_sound_stage_is_a_scene_and_twice_the_same(seeds: range) -> None:
    for seed in seeds:
        stage = random_stage(seed)
        scene = scene_of(stage)
        assert not faults(scene), seed
        assert digest(scene) == digest(scene_of(stage)), seed
        assert views(stage).keys() == {str(one.GetPath()) for one in _cameras(stage)}, seed


def _cameras(stage: Usd.Stage) -> list[Usd.Prim]:
    found = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
    return [prim for prim in found if prim.IsA(UsdGeom.Camera)]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seeds", batches(), ids=lambda seeds: str(seeds[0]))
def test_a_broken_stage_is_a_scene_or_a_sentence(seeds: range) -> None:
    for seed in seeds:
        stage = broken_stage(seed)
        try:
            scene = scene_of(stage)
            views(stage)
        except OrusdError:
            continue
        assert not faults(scene), seed
        if seed % 5 == 0:
            assert digest(scene) == digest(scene_of(broken_stage(seed))), seed


# What generated stages have shown, one by one.


def reasons(scene: Scene, path: str) -> str:
    return "; ".join(why for prim, _, why in scene.report.rows if prim == path)


def test_operations_that_cannot_be_read_do_nothing() -> None:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    shape = UsdGeom.Xform.Define(stage, "/A")
    shape.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    scale = shape.GetPrim().CreateAttribute("xformOp:scale", Sdf.ValueTypeNames.String)
    scale.Set("large")
    shape.GetXformOpOrderAttr().Set(["xformOp:translate", "xformOp:scale"])
    UsdGeom.Cube.Define(stage, "/A/cube")
    UsdLux.SphereLight.Define(stage, "/A/light")
    scene = scene_of(stage)
    for patch in scene.patches:
        middle = patch.triangles.corners.reshape(-1, 3).mean(axis=0)
        np.testing.assert_allclose(middle, [1, 2, 3], atol=1e-9)
    assert len(scene.patches) == 2
    assert "cannot be read" in reasons(scene, "/A")


def test_an_instancer_in_an_instance_takes_prototypes_from_elsewhere() -> None:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Cube.Define(stage, "/Things/cube")
    instancer = UsdGeom.PointInstancer.Define(stage, "/Models/m/scattered")
    instancer.CreatePrototypesRel().SetTargets(["/Things/cube"])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(4, 0, 0), Gf.Vec3f(8, 0, 0)])
    for name in "ab":
        prim = UsdGeom.Xform.Define(stage, f"/{name}").GetPrim()
        prim.GetReferences().AddInternalReference("/Models/m")
        prim.SetInstanceable(True)
    for hidden in ("/Things", "/Models"):
        stage.OverridePrim(hidden).SetSpecifier(Sdf.SpecifierClass)
    scene = scene_of(stage)
    assert len(scene.triangles) == 2 * 2 * 12
    assert [path for path in scene.legend.part.values() if "scattered" in path] == [
        f"/{name}/scattered[{number}]" for name in "ab" for number in range(2)
    ]


@pytest.mark.parametrize("name", ["orientationsf", "orientations", "scales"])
def test_an_instancer_with_too_few_turns_or_factors_is_told_of(name: str) -> None:
    """USD reads behind the end of such arrays."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Cube.Define(stage, "/many/cube")
    instancer = UsdGeom.PointInstancer.Define(stage, "/many")
    instancer.CreatePrototypesRel().SetTargets(["/many/cube"])
    instancer.CreateProtoIndicesAttr([0] * 9)
    instancer.CreatePositionsAttr([Gf.Vec3f(0, 0, 0)] * 9)
    one = {"orientationsf": Gf.Quatf(1), "orientations": Gf.Quath(1), "scales": Gf.Vec3f(1)}
    instancer.GetPrim().GetAttribute(name).Set([one[name]])
    scene = scene_of(stage)
    assert not len(scene.triangles)
    assert "do not fit protoIndices" in reasons(scene, "/many")


@pytest.mark.parametrize("metres", [0.0, -1.0, np.nan, np.inf])
def test_units_and_axes_that_are_none_are_those_of_usd_without_any(metres: float) -> None:
    stage = Usd.Stage.CreateInMemory()
    root = stage.GetRootLayer().pseudoRoot
    root.SetInfo("metersPerUnit", metres)
    root.SetInfo("upAxis", "W")
    plane = UsdGeom.Plane.Define(stage, "/plane")
    plane.CreateAxisAttr("Y")
    scene = scene_of(stage)
    corners = scene.triangles.corners
    np.testing.assert_allclose(np.abs(corners[..., :2]), 0.01)
    np.testing.assert_allclose(corners[..., 2], 0.0, atol=1e-12)
    assert "metersPerUnit" in reasons(scene, "/") and "upAxis" in reasons(scene, "/")


def test_values_of_another_type_are_those_of_the_schema() -> None:
    stage = Usd.Stage.CreateInMemory()
    UsdLux.SphereLight.Define(stage, "/light")
    UsdGeom.Cube.Define(stage, "/cube")
    layer = stage.GetRootLayer()
    for name in ("inputs:intensity", "inputs:color", "inputs:radius", "inputs:diffuse"):
        spec = Sdf.AttributeSpec(layer.GetPrimAtPath("/light"), name, Sdf.ValueTypeNames.String)
        spec.default = "many"
    size = Sdf.AttributeSpec(layer.GetPrimAtPath("/cube"), "size", Sdf.ValueTypeNames.TokenArray)
    size.default = ["2"]
    scene = scene_of(stage)
    (patch,) = scene.patches
    assert patch.radiance == (1.0, 1.0, 1.0)
    assert "inputs:color: it is not a colour" in reasons(scene, "/light")


def test_what_reaches_beyond_single_precision_is_left_out() -> None:
    stage = Usd.Stage.CreateInMemory()
    for path, far in (("/near", 1.0), ("/far", 1e30)):
        UsdGeom.Cube.Define(stage, path).AddTranslateOp().Set(Gf.Vec3d(far))
        UsdLux.RectLight.Define(stage, f"{path}/light")
    scene = scene_of(stage)
    assert len(scene.triangles) == 12 + 2
    assert all("exceed the range" in reasons(scene, path) for path in ("/far", "/far/light"))


@pytest.mark.parametrize("scheme", ["none", "catmullClark"])
@pytest.mark.parametrize("type_name", ["float[]", "color3f[]", "texCoord2f[]"])
def test_primvars_without_any_value_are_left_out(scheme: str, type_name: str) -> None:
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
    mesh.CreateSubdivisionSchemeAttr(scheme)
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    name = {"float[]": "displayOpacity", "color3f[]": "displayColor"}.get(type_name, "st")
    kind = Sdf.ValueTypeNames.Find(type_name)
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(name, kind, "vertex")
    primvar.Set([])
    scene = scene_of(stage)
    assert len(scene.triangles) > 0
    assert not faults(scene)


_TRIANGLE = """
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
"""
# What was left of broken stages that were neither, when all that had no part in it was taken out.
NEITHER = {
    "indices of a subset are words": f"""
def Material "look" {{}}
def Mesh "shape" {{
    {_TRIANGLE}
    rel material:binding = </look>
    def GeomSubset "part" {{
        uniform token familyName = "materialBind"
        token[] indices = [""]
    }}
}}""",
    "indices of a primvar are a word": f"""
def Mesh "shape" {{
    {_TRIANGLE}
    color3f[] primvars:displayColor = [(1, 0, 0)]
    string primvars:displayColor:indices = "faceVarying"
}}""",
    "an indexed primvar has elements of no size": f"""
def Mesh "shape" {{
    {_TRIANGLE}
    color3f[] primvars:displayColor = [(1, 0, 0)] (elementSize = 0)
    int[] primvars:displayColor:indices = [0, 0, 0]
}}""",
    "more ids than instances": """
def Cube "cube" {}
def PointInstancer "many" {
    int64[] ids = [0, 1]
    int64[] invisibleIds = [0]
    point3f[] positions = [(0, 0, 0)]
    int[] protoIndices = [0]
    rel prototypes = </cube>
}""",
    "faces that lie back to back": """
def Mesh "shape" {
    int[] faceVertexCounts = [4, 4]
    int[] faceVertexIndices = [0, 1, 2, 1, 0, 3, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
}""",
    "a camera moves beyond numbers": """
def Camera "eye" {
    double3 xformOp:translate = (inf, -1, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}""",
}


@pytest.mark.parametrize("case", NEITHER)
def test_broken_stages_that_were_neither(case: str) -> None:
    stage = Usd.Stage.CreateInMemory()
    assert stage.GetRootLayer().ImportFromString(f"#usda 1.0\n{NEITHER[case]}")
    try:
        scene = scene_of(stage)
        views(stage)
    except OrusdError:
        return
    assert not faults(scene)
