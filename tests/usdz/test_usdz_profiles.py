"""USDZ files for others: the same room, of what they know, by the checker's own rules."""

import json
import os
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade

import openrooms_usd as ou
from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.demo import copy_example
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.exporters import convert_stage
from openrooms_usd.usd.cameras import list_cameras, read_camera
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import bound_material
from openrooms_usd.usd.shading.surfaces import BARE, Texture
from openrooms_usd.usd.shapes.meshes import read_meshes
from orusd_gltf.materials import Looks
from orusd_urdf.looks import PLAIN
from orusd_usdz import UsdzExporter
from orusd_usdz.profiles import PROFILES
from tests.pictures import save_picture
from tests.small import Stage

ROOT = Path(__file__).parents[2]
Check = Callable[[Path], list[str]]


def written(scene: Path, target: Path, profile: str) -> tuple[Usd.Stage, Any]:
    stage = Usd.Stage.Open(str(scene))
    report = UsdzExporter().convert(stage, target, {"profile": profile})
    return Usd.Stage.Open(str(target)), report


def paths(stage: Usd.Stage) -> set[str]:
    return {str(prim.GetPath()) for prim in stage.Traverse()}


def triangles(stage: Usd.Stage) -> dict[str, np.ndarray]:
    return {m.path: m.world_points()[m.mesh.triangles] for m in read_meshes(stage)}


def look(prim: Usd.Prim) -> dict[str, Any]:
    """What a prim shows, files by their names."""
    material = bound_material(prim)
    assert material is not None, prim.GetPath()
    preview, _ = read_preview_surface(material)
    values = {}
    for name in ("base_color", "metallic", "roughness", "normal", "opacity"):
        value = getattr(preview, name)
        if isinstance(value, Texture):
            file = Path(value.file.rstrip("]").replace("[", "/")).name
            value = (file, value.channel, value.color_space, value.scale, value.uv_matrix.tobytes())
        values[name] = value
    return values


@pytest.mark.parametrize("profile", PROFILES)
def test_every_profile_is_the_same_room(
    profile: str, composed_bodies: Path, tmp_path: Path
) -> None:
    ours = Usd.Stage.Open(str(composed_bodies))
    theirs, report = written(composed_bodies, tmp_path / "room.usdz", profile)
    before, after = triangles(ours), triangles(theirs)
    assert after.keys() == before.keys()
    assert all(np.allclose(after[path], before[path], atol=1e-5) for path in before)
    for mesh in read_meshes(ours):
        wanted = look(mesh.prim)
        assert look(theirs.GetPrimAtPath(mesh.path)) == wanted, mesh.path
    for prim in list_cameras(ours):
        there = read_camera(theirs.GetPrimAtPath(prim.GetPath()), 64, 48)
        here = read_camera(prim, 64, 48)
        assert np.allclose(there.world_from_camera, here.world_from_camera, atol=1e-6)
        assert np.allclose(there.K, here.K)
    rows = {path for path, _, _ in report.rows}
    gone = {str(p.GetPath()) for p in ours.Traverse()} - {
        str(p.GetPath()) for p in theirs.Traverse()
    }
    # Of what is left out each prim is named, or what it was below.
    groups = {"Scope", "Xform", ""}
    named = [path for path in gone if ours.GetPrimAtPath(path).GetTypeName() not in groups]
    assert all(any(path.startswith(row) for row in rows) for path in named)


def test_an_exchange_has_no_portals_and_is_else_what_it_was(
    composed_demo: Path, tmp_path: Path
) -> None:
    ours = Usd.Stage.Open(str(composed_demo))
    portals = {str(p.GetPath()) for p in ours.Traverse() if p.IsA(UsdLux.PortalLight)}
    theirs, report = written(composed_demo, tmp_path / "room.usdz", "exchange")
    assert portals and {path for path, _, _ in report.losses()} == portals
    left = {str(p.GetPath()) for p in ours.Traverse()} - {
        str(p.GetPath()) for p in theirs.Traverse()
    }
    assert left == portals
    dome = theirs.GetPrimAtPath("/World/Lights/Environment")
    assert dome and not dome.GetRelationship("portals").GetTargets()
    assert UsdGeom.GetStageUpAxis(theirs) == "Z" and len(theirs.GetRootLayer().subLayerPaths) > 3


def test_a_phone_gets_what_it_knows(composed_bodies: Path, tmp_path: Path) -> None:
    theirs, report = written(composed_bodies, tmp_path / "room.usdz", "arkit")
    assert UsdGeom.GetStageUpAxis(theirs) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(theirs) == 1.0
    assert {str(p.GetTypeName()) for p in theirs.TraverseAll()} <= PROFILES["arkit"].types
    assert not any(prim.IsInstance() for prim in theirs.Traverse())
    known = {"UsdPreviewSurface", "UsdUVTexture", "UsdTransform2d", "UsdPrimvarReader_float2"}
    shaders = [UsdShade.Shader(p) for p in theirs.TraverseAll() if p.IsA(UsdShade.Shader)]
    assert {shader.GetShaderId() for shader in shaders} <= known
    for prim in theirs.TraverseAll():
        # A shader's schema brings one of its own.
        assert set(prim.GetAppliedSchemas()) <= {"MaterialBindingAPI", "NodeDefAPI"}
        assert not [
            n for n in prim.GetAuthoredPropertyNames() if "openrooms" in n or "physics" in n
        ]
    with zipfile.ZipFile(tmp_path / "room.usdz") as archive:
        first, *others = archive.namelist()
    assert first == "scene.usdc"
    assert {Path(name).suffix for name in others} <= {".png", ".jpg"}
    reasons = " ".join(reason for _, _, reason in report.losses())
    assert "DomeLight" in reasons and "its body is left out" in reasons
    assert "its purpose is guide" in reasons and "lights nothing" in reasons


def test_equal_rooms_give_equal_files(composed_demo: Path, tmp_path: Path) -> None:
    for profile in PROFILES:
        for name in "ab":
            written(composed_demo, tmp_path / f"{name}.usdz", profile)
        assert (tmp_path / "a.usdz").read_bytes() == (tmp_path / "b.usdz").read_bytes(), profile


def odd_stage(path: Path) -> Path:
    """What rooms of ours do not hold, and others' do."""
    made = Stage(path=path)
    sky = save_picture(path.parent / "paper.exr", np.full((4, 4, 3), 0.25, np.float32))
    paper = made.material("/World/M/paper", base_color=Texture(sky), emissive=(300.0, 200.0, 0.0))
    made.quad("/World/Paper", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], material=paper)
    bare = made.box("/World/Bare", 1.0)
    bare.CreateDisplayColorAttr([Gf.Vec3f(1.0, 0.5, 0.0)])
    bare.SetResetXformStack(True)
    bare.AddTranslateOp().Set(Gf.Vec3d(3, 0, 1))
    UsdGeom.Plane.Define(made.stage, "/World/Plane")
    cups = UsdGeom.PointInstancer.Define(made.stage, "/World/Cups")
    made.box("/World/Cups/cup", 0.1)
    cups.CreatePrototypesRel().SetTargets(["/World/Cups/cup"])
    cups.CreateProtoIndicesAttr([0])
    cups.CreatePositionsAttr([(0, 0, 0)])
    lamp = UsdLux.SphereLight.Define(made.stage, "/World/Lamp")
    made.box("/World/Lamp/shade", 0.3, material=paper)
    assert lamp
    made.stage.SetDefaultPrim(UsdGeom.Xform.Define(made.stage, "/World").GetPrim())
    made.stage.Save()
    return path


def test_what_a_phone_does_not_know_is_told(tmp_path: Path) -> None:
    scene = odd_stage(tmp_path / "scene.usda")
    theirs, report = written(scene, tmp_path / "out.usdz", "arkit")
    rows = {path: (outcome, reason) for path, outcome, reason in report.rows}
    assert rows["/World/Plane"] == ("skipped", "phones do not support Plane")
    assert rows["/World/Cups"] == ("skipped", "phones do not support PointInstancer")
    assert "PNG of 8 bits" in rows["/World/M/paper"][1] and "white" in rows["/World/M/paper"][1]
    assert theirs.GetPrimAtPath("/World/Lamp").GetTypeName() == "Xform"
    preview, _ = read_preview_surface(bound_material(theirs.GetPrimAtPath("/World/Paper")))
    assert preview.emissive == pytest.approx((1.0, 2 / 3, 0.0))
    assert isinstance(preview.base_color, Texture) and preview.base_color.color_space == "sRGB"
    # What has no material gets one: phones pass over displayColor.
    bare, _ = read_preview_surface(bound_material(theirs.GetPrimAtPath("/World/Bare")))
    assert bare.base_color == (1.0, 0.5, 0.0)
    before = triangles(Usd.Stage.Open(str(scene)))
    after = triangles(theirs)
    assert after.keys() == before.keys() - {"/World/Plane", "/World/Cups[0]"}
    assert all(np.allclose(after[path], before[path], atol=1e-6) for path in after)


def test_without_a_material_every_form_has_the_same_grey(tmp_path: Path) -> None:
    made = Stage(path=tmp_path / "scene.usda")
    made.box("/World/Bare", 1.0)
    made.stage.SetDefaultPrim(made.stage.GetPrimAtPath("/World"))
    made.stage.Save()
    theirs, _ = written(tmp_path / "scene.usda", tmp_path / "out.usdz", "arkit")
    shown, _ = read_preview_surface(bound_material(theirs.GetPrimAtPath("/World/Bare")))
    (mesh,) = read_meshes(made.stage)
    ((_, glb),) = Looks().parts(mesh)
    robots = linear_from_srgb(np.array(PLAIN.color))
    for grey in (shown.base_color, glb.preview.base_color, robots):
        assert grey == pytest.approx(BARE.base_color)


def test_mistakes_are_told(composed_demo: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(composed_demo))
    for options, message in (({"profile": "phone"}, "no profile"), ({"size": 3}, "no option")):
        with pytest.raises(InputError, match=message):
            UsdzExporter().convert(stage, tmp_path / "a.usdz", options)
    with pytest.raises(StageError, match="not saved in a file"):
        UsdzExporter().convert(Usd.Stage.CreateInMemory(), tmp_path / "a.usdz", {})
    assert not list(tmp_path.iterdir())


def test_layers_from_elsewhere_stay_where_they_are(tmp_path: Path) -> None:
    inside, outside = tmp_path / "room", tmp_path / "elsewhere"
    for folder in (inside, outside):
        folder.mkdir()
    guest = Stage(path=outside / "guest.usda")
    guest.box("/Guest", 1.0)
    guest.stage.SetDefaultPrim(guest.stage.GetPrimAtPath("/Guest"))
    guest.stage.Save()
    made = Stage(path=inside / "scene.usda")
    made.stage.DefinePrim("/Guest").GetReferences().AddReference("../elsewhere/guest.usda")
    made.stage.Save()
    for profile in PROFILES:
        file, asked = tmp_path / f"{profile}.usdz", {"to": "usdz", "options": {"profile": profile}}
        with pytest.raises(StageError, match="outside"):
            convert_stage(inside / "scene.usda", file, **asked)
        assert not file.exists()
        convert_stage(inside / "scene.usda", file, include_outside=True, **asked)
        assert len(triangles(Usd.Stage.Open(str(file)))) == 1


@pytest.fixture(scope="session")
def apple() -> Check:
    """What Apple's rules say of a file; runs where `.ci/install-usdchecker` has been."""
    python = os.environ.get("ORUSD_USDCHECKER_PYTHON", str(ROOT / ".venv-usdchecker/bin/python"))
    if not Path(python).is_file():
        pytest.skip("usdchecker is missing (.ci/install-usdchecker, ORUSD_USDCHECKER_PYTHON)")

    def check(file: Path) -> list[str]:
        command = [python, "-P", str(Path(__file__).parent / "check.py"), str(file)]
        environment = {key: x for key, x in os.environ.items() if not key.startswith("PYTHON")}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120)
        assert done.returncode == 0, done.stdout + done.stderr
        return json.loads(done.stdout)  # type: ignore[no-any-return]

    return check


def test_apples_rules_accept_the_room(composed_bodies: Path, apple: Check, tmp_path: Path) -> None:
    written(composed_bodies, tmp_path / "phone.usdz", "arkit")
    assert apple(tmp_path / "phone.usdz") == []
    written(odd_stage(tmp_path / "scene.usda"), tmp_path / "odd.usdz", "arkit")
    assert apple(tmp_path / "odd.usdz") == []
    # The rules find what the default profile holds.
    written(composed_bodies, tmp_path / "usual.usdz", "default")
    found = " ".join(apple(tmp_path / "usual.usdz"))
    assert "upAxis" in found and "DomeLight" in found


def test_usds_own_validators_accept_every_profile(composed_bodies: Path, tmp_path: Path) -> None:
    from pxr import UsdValidation

    for profile in PROFILES:
        stage, _ = written(composed_bodies, tmp_path / f"{profile}.usdz", profile)
        errors = UsdValidation.ValidationContext(
            UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        ).Validate(stage)
        assert [error.GetMessage() for error in errors] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["example", "kitchen", pytest.param("bedroom", marks=pytest.mark.long)]
)
def test_apples_rules_accept_whole_rooms(name: str, apple: Check, tmp_path: Path) -> None:
    room = copy_example(tmp_path / "source") if name == "example" else ou.generate(name, seed=5)
    scene = ou.compose(room, tmp_path / "out").path
    for profile in PROFILES:
        stage, _ = written(scene, tmp_path / f"{profile}.usdz", profile)
        assert triangles(stage).keys() == triangles(Usd.Stage.Open(str(scene))).keys()
    assert apple(tmp_path / "arkit.usdz") == []
