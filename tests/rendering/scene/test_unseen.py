"""What is in no picture is named: attributes and schemas that nobody reads, where they stand."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.shapes.meshes import read_meshes
from tests import small


def told(stage: Usd.Stage) -> dict[str, str]:
    rows = translate(stage).report.losses()
    found: dict[str, str] = {}
    for prim, _, reason in rows:
        assert prim not in found, "a prim is named once"
        found[prim] = reason
    return found


def model(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A body with a draw mode that nobody reads."""
    prim = stage.DefinePrim(path, "Cube")
    UsdGeom.ModelAPI.Apply(prim).CreateModelDrawModeAttr("cards")
    return prim


def test_what_the_table_tells_of_is_named_with_what_was_lost_before() -> None:
    stage = Usd.Stage.CreateInMemory()
    model(stage, "/Body").ApplyAPI("LODRootAPI")
    assert told(stage) == {
        "/Body": "it has no material: grey is used; "
        "LODRootAPI: all levels of detail are drawn at once; "
        "model:drawMode: models are drawn whole"
    }


def test_values_that_mean_nothing_are_not_told_of() -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = model(stage, "/Body")
    prim.ApplyAPI("ColorSpaceAPI")
    UsdGeom.TetMesh.Define(stage, "/Body/Empty").CreateNormalsAttr([])
    for mode in ("default", "inherited"):
        prim.GetAttribute("model:drawMode").Set(mode)
        for space in ("", "lin_rec709_scene"):
            prim.GetAttribute("colorSpace:name").Set(space)
            assert told(stage)["/Body"] == "it has no material: grey is used"
    prim.GetAttribute("colorSpace:name").Set("lin_ap1_scene")
    assert "colorSpace:name" in told(stage)["/Body"]
    assert "normals" not in told(stage)["/Body/Empty"]


def test_inside_of_instances_the_first_is_named() -> None:
    """Also where the instance is itself inside of an instance."""
    stage = Usd.Stage.CreateInMemory()
    model(stage, "/Inner/Body")
    for outer, inner in (("/Outer/a", "/Inner"), ("/World/b", "/Outer"), ("/World/c", "/Outer")):
        prim = stage.DefinePrim(outer, "Xform")
        prim.GetReferences().AddInternalReference(inner)
        prim.SetInstanceable(True)
    for path in ("/Inner", "/Outer"):
        stage.GetPrimAtPath(path).SetSpecifier(Sdf.SpecifierClass)
    named = {path for path, why in told(stage).items() if "drawMode" in why}
    assert named == {"/World/b/a/Body"}


def test_subsets_whose_material_is_not_shown_are_named() -> None:
    stage = Usd.Stage.CreateInMemory()
    for kind, elements in (("TetMesh", "face"), ("Mesh", "face"), ("Mesh", "edge")):
        path = f"/{kind}_{elements}"
        stage.DefinePrim(path, kind)
        subset = UsdGeom.Subset.Define(stage, f"{path}/Part")
        subset.CreateElementTypeAttr(elements)
        subset.CreateFamilyNameAttr(UsdShade.Tokens.materialBind)
    UsdGeom.Subset.Define(stage, "/TetMesh_face/Group").CreateFamilyNameAttr("of_people")
    said = {path: why for path, why in told(stage).items() if "/Part" in path or "/Group" in path}
    assert said == {
        "/TetMesh_face/Part": "its material is left out: it has faces of a TetMesh",
        "/Mesh_edge/Part": "its material is left out: it has edges of a Mesh",
    }


def test_types_of_others_are_named() -> None:
    stage = Usd.Stage.CreateInMemory()
    for kind in ("OfNobody", "Volume", "OpenVDBAsset", "PhysicsScene", "Backdrop", ""):
        stage.DefinePrim(f"/{kind or 'Plain'}", kind)
    assert told(stage) == {
        "/OfNobody": "OfNobody does not appear in a picture",
        "/Volume": "Volume without a known surface",
        "/OpenVDBAsset": "OpenVDBAsset: volumes are not drawn",
    }


def test_a_volume_of_a_material_is_named_where_something_makes_it() -> None:
    stage = Usd.Stage.CreateInMemory()
    plain, fog = (UsdShade.Material.Define(stage, f"/{name}") for name in ("Plain", "Fog"))
    shader = UsdShade.Shader.Define(stage, "/Fog/Shader")
    output = shader.CreateOutput("volume", Sdf.ValueTypeNames.Token)
    fog.CreateVolumeOutput().ConnectToSource(output)
    plain.CreateVolumeOutput()
    assert told(stage) == {"/Fog": "outputs:volume: what is inside of it is empty"}


def test_a_displacement_is_named_where_its_shader_does_not_tell_of_it() -> None:
    stage = Usd.Stage.CreateInMemory()
    kinds = {
        "Preview": "UsdPreviewSurface",
        "Same": "ND_UsdPreviewSurface_surfaceshader",
        "Other": "ND_displacement_float",
    }
    for name, kind in kinds.items():
        material = UsdShade.Material.Define(stage, f"/{name}")
        shader = UsdShade.Shader.Define(stage, f"/{name}/Shader")
        shader.CreateIdAttr(kind)
        output = shader.CreateOutput("displacement", Sdf.ValueTypeNames.Token)
        material.CreateDisplacementOutput().ConnectToSource(output)
    assert told(stage) == {"/Other": "outputs:displacement: nothing is moved"}


def test_bindings_that_lead_nowhere_are_told() -> None:
    made = small.Stage()
    for path in ("/World/mesh", "/World/by_parent/mesh", "/World/whole"):
        mesh = made.box(path, 0.5)
    subset = UsdShade.MaterialBindingAPI(mesh).CreateMaterialBindSubset("front", [2])
    wrong = {
        "/World/mesh": "/Looks/None",
        "/World/by_parent": "/World",
        str(subset.GetPath()): "/Looks/Other",
    }
    for path, target in wrong.items():
        prim = made.stage.GetPrimAtPath(path)
        UsdShade.MaterialBindingAPI.Apply(prim)
        prim.CreateRelationship("material:binding", custom=False).SetTargets([target])
    rows = {path: why for path, _, why in translate(made.stage).report.losses()}
    assert {path for path, why in rows.items() if "is missing" in why} == set(wrong)
    assert all(rows[path].endswith(f"there is none at {target}") for path, target in wrong.items())


@pytest.mark.parametrize("scheme", ["none", "catmullClark"])
def test_texture_coordinates_of_three_numbers(scheme: str) -> None:
    made = small.Stage()
    mesh = made.quad("/Q", small.square((0, 0, 0), 1.0, "+Z"))
    mesh.GetSubdivisionSchemeAttr().Set(scheme)
    flat = [(0.1, 0.2), (0.8, 0.2), (0.8, 0.9), (0.1, 0.9)]
    api = UsdGeom.PrimvarsAPI(mesh)
    for third, told in ((0.0, False), (0.5, True)):
        for name, count in (("st", 2), ("st", 3)):
            kind = getattr(Sdf.ValueTypeNames, f"TexCoord{count}fArray")
            api.RemovePrimvar(name)
            primvar = api.CreatePrimvar(name, kind, "faceVarying")
            rows = [(*row, third * number)[:count] for number, row in enumerate(flat)]
            primvar.Set([(Gf.Vec2f, Gf.Vec3f)[count - 2](*row) for row in rows])
            found = read_meshes(made.stage)
            if count == 2:
                expected = found.meshes[0].mesh.uvs["st"]
        assert np.array_equal(found.meshes[0].mesh.uvs["st"], expected)
        assert any("three numbers" in why for _, _, why in found.losses) == told


@pytest.mark.parametrize("where", ["plain", "native", "scattered", "abstract"])
def test_what_is_not_read_is_told_wherever_it_stands(where: str) -> None:
    stage = Usd.Stage.CreateInMemory()
    home = "/Proto" if where in ("native", "abstract") else "/World/Proto"
    stage.DefinePrim(home, "Xform")
    if where in ("native", "abstract"):
        stage.GetPrimAtPath(home).SetSpecifier(Sdf.SpecifierClass)
    model(stage, f"{home}/Body")
    stage.DefinePrim(f"{home}/Made", "GenerativeProcedural")
    if where == "native":
        prim = stage.DefinePrim("/World/A", "Xform")
        prim.GetReferences().AddInternalReference(home)
        prim.SetInstanceable(True)
        home = "/World/A"
    elif where != "plain":
        instancer = UsdGeom.PointInstancer.Define(stage, "/World/S")
        instancer.CreatePrototypesRel().AddTarget(home)
        instancer.CreateProtoIndicesAttr([0])
        instancer.CreatePositionsAttr([(0, 0, 0)])
    found = told(stage)
    assert "model:drawMode" in found[f"{home}/Body"]
    assert "what a program would make" in found[f"{home}/Made"]
