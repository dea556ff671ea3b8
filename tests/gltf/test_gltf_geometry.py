"""What stands where in a GLB file is what stands there in the stage."""

import json
import math
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd.errors import MissingPackageError
from openrooms_usd.usd.light.lights import define_mesh_light
from openrooms_usd.usd.shading.surfaces import Texture
from openrooms_usd.usd.shapes.meshes import read_meshes
from orusd_gltf import GltfExporter
from tests.gltf.conftest import Export
from tests.gltf.reading import Glb, local, read, volume
from tests.gltf.test_gltf_materials import CORNERS
from tests.pictures import save_picture
from tests.small import Stage

SHEAR = Gf.Matrix4d(1, 0.4, 0, 0, 0, 1, 0.3, 0, 0.2, 0, 1, 0, 0.5, 1, 2, 1)


def of_stage(stage: Usd.Stage) -> dict[str, np.ndarray]:
    """(M, 3, 3) corners in the world by the path where they stand, the front counter-clockwise."""
    found = {}
    for mesh in read_meshes(stage):
        corners = mesh.world_points()[mesh.mesh.triangles]
        found[mesh.path] = corners[:, ::-1] if mesh.mirrored else corners
    return found


def assert_same(glb: Glb, stage: Usd.Stage) -> None:
    ours, theirs = of_stage(stage), glb.triangles()
    assert theirs.keys() == ours.keys()
    for path, corners in ours.items():
        # Which corner of a triangle comes first says nothing.
        order = [np.roll(theirs[path], turn, axis=1) for turn in range(3)]
        off = np.min([np.abs(one - corners).max(axis=(1, 2)) for one in order], axis=0)
        assert off.max() < 1e-5, path


def test_meshes_stand_where_they_stood_whatever_moves_turns_mirrors_or_shears_them(
    export: Export,
) -> None:
    made = Stage(up="Y", metres=0.01)
    made.box("/A/plain", 30.0).AddTranslateOp().Set(Gf.Vec3d(100, 20, 3))
    UsdGeom.Xform.Define(made.stage, "/A").AddRotateXYZOp().Set(Gf.Vec3f(20, 30, 40))
    made.box("/A/mirrored", 20.0).AddScaleOp().Set(Gf.Vec3f(-1, 2, 3))
    made.box("/A/sheared", 20.0).AddTransformOp().Set(SHEAR)
    # Inside of a shear and a mirror, and out of all of it.
    UsdGeom.Xform.Define(made.stage, "/S").AddTransformOp().Set(SHEAR * Gf.Matrix4d().SetScale(-2))
    made.box("/S/child", 10.0).AddRotateZOp().Set(33.0)
    free = made.box("/S/free", 5.0)
    free.AddTranslateOp().Set(Gf.Vec3d(7, 8, 9))
    free.SetResetXformStack(True)
    UsdGeom.Sphere.Define(made.stage, "/Ball").CreateRadiusAttr(40.0)
    glb, report = export(made.stage)
    assert_same(glb, made.stage)
    assert all(volume(corners) > 0 for corners in glb.triangles().values())
    assert volume(glb.triangles()["/A/mirrored"]) == pytest.approx(6 * 0.2**3, rel=1e-4)
    assert report.count("skipped") == 0


def test_what_repeats_is_stored_once(export: Export) -> None:
    made = Stage()
    made.box("/Parts/chair/seat", 0.4)
    made.stage.GetPrimAtPath("/Parts").SetSpecifier(Sdf.SpecifierClass)
    for number in range(3):
        chair = UsdGeom.Xform.Define(made.stage, f"/World/chair_{number}")
        chair.AddTranslateOp().Set(Gf.Vec3d(number, 0, 0))
        chair.GetPrim().GetReferences().AddInternalReference("/Parts/chair")
        chair.GetPrim().SetInstanceable(True)
    scattered = UsdGeom.PointInstancer.Define(made.stage, "/World/Cups")
    made.box("/World/Cups/cup", 0.1)
    scattered.CreatePrototypesRel().SetTargets(["/World/Cups/cup"])
    scattered.CreateProtoIndicesAttr([0, 0])
    scattered.CreatePositionsAttr([(0, 1, 0), (0, 2, 1)])
    glb, _ = export(made.stage)
    assert_same(glb, made.stage)
    assert len(glb.json["meshes"]) == 2
    assert [node["name"] for node in glb.json["nodes"] if "mesh" in node].count("seat") == 3


def test_the_same_stage_gives_the_same_bytes(composed_demo: Path, tmp_path: Path) -> None:
    for name in ("a.glb", "b.glb"):
        GltfExporter().convert(Usd.Stage.Open(str(composed_demo)), tmp_path / name, {})
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_trimesh_reads_a_room_as_it_is(composed_demo: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(composed_demo))
    report = GltfExporter().convert(stage, tmp_path / "room.glb", {})
    assert_same(read(tmp_path / "room.glb"), stage)
    scene = trimesh.load_scene(tmp_path / "room.glb")
    ours = of_stage(stage)
    assert len(scene.graph.nodes_geometry) == len(ours)
    assert sum(len(g.faces) for g in scene.dump()) == sum(map(len, ours.values()))
    corners = np.concatenate(list(ours.values())).reshape(-1, 3)
    x, y, z = corners.T
    assert np.allclose(scene.bounds, [(x.min(), z.min(), -y.max()), (x.max(), z.max(), -y.min())])
    whole = sum(volume(corners) for corners in ours.values())
    assert sum(volume(g.triangles) for g in scene.dump()) == pytest.approx(whole, rel=1e-4)
    # Trimesh numbers what has the name of another.
    names = Counter(path.rpartition("/")[2].rstrip("_0123456789") for path in ours)
    found = (node.rstrip("_0123456789") for node in scene.graph.nodes_geometry)
    assert Counter(found) == names
    rows = {prim for prim, _, _ in report.rows}
    assert rows >= {str(p.GetPath()) for p in stage.Traverse() if p.IsA(UsdGeom.Gprim)}


def written(scene: Path, target: Path, **options: str) -> Glb:
    GltfExporter().convert(Usd.Stage.Open(str(scene)), target, options)
    return read(target)


def test_draco_keeps_shapes_to_a_millimetre(composed_demo: Path, tmp_path: Path) -> None:
    plain = written(composed_demo, tmp_path / "plain.glb")
    packed = written(composed_demo, tmp_path / "packed.glb", compression="draco")
    assert packed.json["extensionsRequired"] == ["KHR_draco_mesh_compression"]
    vertices = len(plain.data) - sum(
        view["byteLength"] for view in plain.json["bufferViews"] if "target" not in view
    )
    pictures = len(plain.data) - vertices
    assert len(packed.data) - pictures < 0.2 * vertices
    ours, theirs = (trimesh.load_scene(tmp_path / f"{n}.glb") for n in ("plain", "packed"))
    assert ours.geometry.keys() == theirs.geometry.keys()
    for name, shape in ours.geometry.items():
        other = theirs.geometry[name]
        assert len(other.faces) == len(shape.faces)
        assert np.abs(other.bounds - shape.bounds).max() < 1e-3
        assert other.area == pytest.approx(shape.area, rel=0.02)
        uv, wanted = other.visual.uv, shape.visual.uv
        assert (uv is None) == (wanted is None)
        if uv is not None:
            assert np.abs(np.ptp(uv, axis=0) - np.ptp(wanted, axis=0)).max() < 1e-2


def test_draco_is_asked_for_where_it_is_missing(
    export: Export, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    made = Stage()
    made.box("/Box", 1.0)
    with pytest.raises(MissingPackageError) as told:
        export(made.stage, {"compression": "draco"})
    assert "draco" in str(told.value.remedy)


def test_one_node_draws_all_places_of_a_mesh(export: Export) -> None:
    made = Stage()
    made.box("/Parts/chair/seat", 0.4)
    made.stage.GetPrimAtPath("/Parts").SetSpecifier(Sdf.SpecifierClass)
    places = [(0.0, 0.0, 0.0, 1.0), (1.0, 2.0, 30.0, 1.0), (2.0, 0.0, 80.0, 2.0), (3.0, 1.0, 0, -1)]
    for number, (x, y, turn, size) in enumerate(places):
        chair = UsdGeom.Xform.Define(made.stage, f"/World/chair_{number}")
        chair.AddTranslateOp().Set(Gf.Vec3d(x, y, 0.5))
        chair.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, turn))
        chair.AddScaleOp().Set(Gf.Vec3f(size, abs(size), 1.5))
        chair.GetPrim().GetReferences().AddInternalReference("/Parts/chair")
        chair.GetPrim().SetInstanceable(True)
    plain, _ = export(made.stage)
    glb, _ = export(made.stage, {"instances": "gpu"})
    assert glb.json["extensionsRequired"] == ["EXT_mesh_gpu_instancing"]
    worlds = {n["extras"]["prim"]: world for n, world in plain.placed() if "mesh" in n}
    (drawn, rest) = sorted(
        (n for n in glb.json["nodes"] if "mesh" in n), key=lambda n: "extensions" not in n
    )
    # The mirrored one has a node of its own.
    assert rest["extras"]["prim"] == "/World/chair_3/seat"
    said = drawn["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
    columns = {name.lower(): glb.accessor(number) for name, number in said.items()}
    for row, prim in enumerate(drawn["extras"]["prims"]):
        world = local({name: values[row] for name, values in columns.items()})
        assert np.allclose(world, worlds[prim], atol=1e-6)
    assert len(drawn["extras"]["prims"]) == 3
    names = [node["name"] for node in glb.json["nodes"]]
    assert names.count("seat") == 4


@pytest.mark.parametrize("form", ["jpeg", "webp"])
def test_pictures_are_stored_smaller(form: str, export: Export, tmp_path: Path) -> None:
    made = Stage()
    rows, columns = np.mgrid[0:64, 0:64] / 64.0
    codes = np.stack([rows, columns, 0.5 + 0 * rows, 1 - rows], axis=-1)
    codes = np.round(codes * 255).astype(np.uint8)
    color = Texture(save_picture(tmp_path / "color.png", codes[..., :3]), color_space="sRGB")
    clear = Texture(save_picture(tmp_path / "clear.png", codes[..., 3:]), channel="r")
    made.quad("/Plain", CORNERS, material=made.material("/M", base_color=color))
    leaf = made.material("/Leaf", base_color=color, opacity=clear)
    made.quad("/Cut", CORNERS, material=leaf)
    glb, _ = export(made.stage, {"pictures": form})
    kinds = [image["mimeType"] for image in glb.json["images"]]
    assert kinds == [f"image/{form}", "image/png" if form == "jpeg" else "image/webp"]
    assert ("extensionsRequired" in glb.json) == (form == "webp")
    for number, channels in ((0, 3), (1, 4)):
        shown = glb.picture({"index": number}, tmp_path)
        assert np.abs(shown - codes[..., :channels] / 255.0).mean() < 0.02


SURFACES: tuple[dict[str, Any], ...] = (
    {"base_color": (2.0, -1.0, 0.5)},
    {"roughness": 3.0, "metallic": -1.0},
    {"opacity": 1.5},
    {"opacity": -0.5},
    {"opacity_threshold": 2.0, "opacity": 0.5},
    {"ior": 0.2},
    {"clearcoat": 3.0, "clearcoat_roughness": 2.0},
    {"emissive": (-1.0, 2.0, 0.0)},
    {"emissive": (1e38, 0.0, 0.0)},
    {"specular": (2.0, 0.1, -1.0)},
    {"base_color": Texture("missing.png")},
    {"normal": Texture("missing.png")},
    {"roughness": Texture("missing.png"), "metallic": Texture("none.png", primvar="uv7")},
    {"emissive": Texture("missing.png", scale=(0.0, 0.0, 0.0, 0.0))},
)


def odd_stage() -> Usd.Stage:
    made = Stage()
    far, corners = 1e39, ((0, 0), (1, 0), (1, 1), (0, 1))
    for name, size in (("huge", far), ("none", math.nan), ("tiny", 1e-30)):
        made.quad(f"/W/{name}", [(x * size, y * size, 0) for x, y in corners])
    made.box("/W/scaled", 1.0).AddScaleOp().Set(Gf.Vec3f(1e30, 1e30, 1e30))
    made.box("/W/flat", 1.0).AddScaleOp().Set(Gf.Vec3f(0, 1, 1))
    thin = Gf.Matrix4d(1, 1, 0, 0, 1, 1.0000001, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)
    made.box("/W/thin", 1.0).AddTransformOp().Set(thin)
    for number, inputs in enumerate(SURFACES):
        made.box(f"/W/box_{number}", 1.0, material=made.material(f"/M/m{number}", **inputs))
    for name, clipping in (("/Endless", (0.0, math.inf)), ("/Reversed", (5.0, 1.0))):
        made.camera((0, -4, 0), (0, 0, 0), path=name)
        camera = UsdGeom.Camera(made.stage.GetPrimAtPath(name))
        camera.CreateClippingRangeAttr(Gf.Vec2f(*clipping))
        camera.CreateExposureAttr(math.nan)
    for name, nits, radius in (("/L/bright", 1e38, 1e10), ("/L/dark", 0.0, 1.0)):
        lamp = UsdLux.SphereLight.Define(made.stage, name)
        lamp.CreateIntensityAttr(nits)
        lamp.CreateRadiusAttr(radius)
    flat = UsdLux.RectLight.Define(made.stage, "/L/flat")
    flat.AddScaleOp().Set(Gf.Vec3f(0, 1, 1))
    define_mesh_light(made.box("/W/dark", 1.0).GetPrim(), nits=0.0)
    return made.stage


@pytest.mark.parametrize("options", [{}, {"exposure": "camera"}, {"compression": "draco"}], ids=str)
def test_odd_stages_are_written_in_bounds(options: dict[str, str], tmp_path: Path) -> None:
    report = GltfExporter().convert(odd_stage(), tmp_path / "odd.glb", options)
    rows = {path: outcome for path, outcome, _ in report.rows}
    lost = {path for path, outcome in rows.items() if outcome == "skipped"}
    assert lost == {"/W/huge", "/W/none", "/W/scaled", "/W/flat", "/L/flat"}
    said = read(tmp_path / "odd.glb").json
    assert len([node for node in said["nodes"] if "mesh" in node]) == len(SURFACES) + 3
    for material in said["materials"]:
        base = material["pbrMetallicRoughness"]
        factors = [*base.get("baseColorFactor", ()), *material.get("emissiveFactor", ())]
        factors += [base.get("metallicFactor", 0.0), base.get("roughnessFactor", 0.0)]
        assert all(0.0 <= factor <= 1.0 for factor in factors), material
    for camera in said["cameras"]:
        view = camera["perspective"]
        assert 0.0 < view["znear"] < view.get("zfar", math.inf)


@pytest.mark.slow
def test_the_validator_finds_nothing_in_them(node: Callable[..., str], tmp_path: Path) -> None:
    GltfExporter().convert(odd_stage(), tmp_path / "odd.glb", {})
    (report,) = json.loads(node("validate.mjs", tmp_path / "odd.glb"))
    issues = report["issues"]
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"][:5]
