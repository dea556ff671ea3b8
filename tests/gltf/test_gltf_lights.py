"""Lamps are as bright from afar as here, cameras see as much, and nothing is lost in silence."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from pxr import Gf, Usd, UsdGeom, UsdLux

from openrooms_usd import adapters
from openrooms_usd.cli import orusd
from openrooms_usd.errors import InputError
from openrooms_usd.exporters import exporter_of
from openrooms_usd.usd.light.lights import define_mesh_light
from orusd_gltf import GltfExporter
from tests.gltf.conftest import Export
from tests.gltf.reading import Glb
from tests.small import Stage


def lamps(glb: Glb) -> dict[str, tuple[dict, np.ndarray]]:
    """Each light by its name, with its place in the world, Z up."""
    listed = glb.json["extensions"]["KHR_lights_punctual"]["lights"]
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    found = {}
    for node, world in glb.placed():
        if light := node.get("extensions", {}).get("KHR_lights_punctual"):
            item = listed[light["light"]]
            found[item["name"]] = item, turn @ world[:3]
    return found


def test_lamps_have_the_candela_of_their_surface(export: Export) -> None:
    made = Stage()
    ball = UsdLux.SphereLight.Define(made.stage, "/L/Ball")
    ball.CreateRadiusAttr(0.2)
    ball.CreateIntensityAttr(100.0)
    ball.CreateColorAttr(Gf.Vec3f(1.0, 0.5, 0.25))
    ball.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    panel = UsdLux.RectLight.Define(made.stage, "/L/Panel")
    panel.CreateWidthAttr(0.5)
    panel.CreateHeightAttr(2.0)
    panel.CreateIntensityAttr(30.0)
    panel.AddRotateXOp().Set(90.0)
    panel.AddScaleOp().Set(Gf.Vec3f(2, 1, 1))
    disk = UsdLux.DiskLight.Define(made.stage, "/L/Disk")
    disk.CreateRadiusAttr(0.3)
    disk.CreateIntensityAttr(10.0)
    tube = UsdLux.CylinderLight.Define(made.stage, "/L/Tube")
    tube.CreateRadiusAttr(0.05)
    tube.CreateLengthAttr(1.2)
    tube.CreateIntensityAttr(40.0)
    sun = UsdLux.DistantLight.Define(made.stage, "/L/Sun")
    sun.CreateIntensityAttr(1000.0)
    sun.CreateAngleAttr(0.0)
    sun.AddRotateYOp().Set(90.0)
    bulb = made.box("/Bulb", 0.1)
    bulb.AddTranslateOp().Set(Gf.Vec3d(0, 0, 2))
    define_mesh_light(bulb.GetPrim(), nits=5000.0)
    lit = made.quad("/Lit", [(0, 0, 3), (0, 1, 3), (2, 1, 3), (2, 0, 3)])
    define_mesh_light(lit.GetPrim(), nits=100.0)
    made.dome()
    glb, report = export(made.stage)
    found = lamps(glb)

    def seen(name: str, kind: str, candela: float) -> np.ndarray:
        item, world = found[name]
        assert item["type"] == kind
        assert item["intensity"] == pytest.approx(candela, rel=1e-3)
        return world

    # From afar a lamp's candela is its radiance times the area that it shows.
    assert np.allclose(seen("Ball", "point", 100.0 * math.pi * 0.2**2)[:, 3], (1, 2, 3))
    assert found["Ball"][0]["color"] == [1.0, 0.5, 0.25]
    # -Z of the light, turned about X by a quarter, is +Y of the world.
    assert np.allclose(seen("Panel", "spot", 30.0 * 2.0)[:, 2], (0, -1, 0), atol=1e-9)
    seen("Disk", "spot", 10.0 * math.pi * 0.09)
    seen("Tube", "point", 40.0 * 2 * math.pi * 0.05 * 1.2 / 4)
    assert np.allclose(seen("Sun", "directional", 1000.0)[:, 2], (1, 0, 0), atol=1e-9)
    # A convex body shows a quarter of its surface in the mean; a panel all of it, to its front.
    assert np.allclose(seen("Bulb_light", "point", 5000.0 * 0.06 / 4)[:, 3], (0, 0, 2))
    panel_there = seen("Lit_light", "spot", 100.0 * 2.0)
    assert np.allclose(panel_there[:, 3], (1, 0.5, 3))
    assert np.allclose(panel_there[:, 2] / np.linalg.norm(panel_there[:, 2]), (0, 0, 1))
    rows = {prim: (outcome, reason) for prim, outcome, reason in report.rows}
    assert rows["/Dome"][0] == "skipped" and "surroundings" in rows["/Dome"][1]
    assert rows["/L/Ball"][0] == rows["/Bulb"][0] == "approximated"


def test_a_mesh_glows_as_its_light_does(export: Export) -> None:
    made = Stage()
    grey = made.material("/Grey", base_color=(0.5, 0.5, 0.5))
    made.box("/Dark", 1.0, material=grey)
    define_mesh_light(made.box("/Bulb", 0.1, material=grey).GetPrim(), nits=5000.0)
    glb, _ = export(made.stage)
    strengths = {}
    for mesh in glb.json["meshes"]:
        material = glb.json["materials"][mesh["primitives"][0]["material"]]
        strong = material.get("extensions", {}).get("KHR_materials_emissive_strength", {})
        strengths[mesh["name"]] = strong.get("emissiveStrength", 0.0)
    assert strengths == {"Dark": 0.0, "Bulb": 5000.0}


def test_parallel_cameras_see_as_much(export: Export) -> None:
    made = Stage()
    made.camera((0, -4, 1), (0, 0, 1), aspect=4 / 3)
    camera = UsdGeom.Camera(made.stage.GetPrimAtPath("/Camera"))
    camera.CreateProjectionAttr("orthographic")
    camera.GetHorizontalApertureAttr().Set(60.0)
    camera.CreateClippingRangeAttr((-2.0, 9.0))
    glb, _ = export(made.stage)
    (said,) = glb.json["cameras"]
    assert said["type"] == "orthographic"
    expected = {"xmag": 3.0, "ymag": 2.25, "znear": 0.0, "zfar": 9.0}
    assert said["orthographic"] == pytest.approx(expected)


def test_cameras_see_as_much(export: Export) -> None:
    made = Stage()
    made.camera((0, -4, 1), (0, 0, 1), fov=70.0, aspect=4 / 3)
    camera = UsdGeom.Camera(made.stage.GetPrimAtPath("/Camera"))
    camera.CreateExposureAttr(-7.5)
    camera.CreateHorizontalApertureOffsetAttr(0.0)
    glb, _ = export(made.stage)
    (said,) = glb.json["cameras"]
    wide = 2 * math.atan(math.tan(said["perspective"]["yfov"] / 2) * 4 / 3)
    assert math.degrees(wide) == pytest.approx(70.0)
    assert said["perspective"]["aspectRatio"] == pytest.approx(4 / 3)
    ((node, world),) = ((n, w) for n, w in glb.placed() if "camera" in n)
    assert node["name"] == "Camera" and node["extras"]["exposure"] == -7.5
    # It stands at y = -4, 1 m up, and looks along +Y of the stage: -Z of glTF.
    assert np.allclose(world[:3, 3], (0, 1, 4)) and np.allclose(world[:3, 2], (0, 0, 1), atol=1e-7)


def test_options_that_are_not_known_are_refused(tmp_path: Path) -> None:
    stage = Stage().stage
    for options in ({"draco": True}, {"pictures": "gif"}):
        with pytest.raises(InputError):
            GltfExporter().convert(stage, tmp_path / "a.glb", options)
    assert not list(tmp_path.iterdir())
    report = GltfExporter().convert(stage, tmp_path / "empty.glb", {})
    assert report.rows == []


def test_the_ending_says_which_exporter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert exporter_of(Path("room.GLB")) == "gltf"
    assert exporter_of(Path("scene.xml")) == exporter_of(Path("folder")) == "mitsuba"
    loaded = []

    def load(group: str, name: str) -> GltfExporter:
        loaded.append((group, name))
        return GltfExporter()

    monkeypatch.setattr(adapters, "load", load)
    made = Stage(path=tmp_path / "scene.usda")
    made.box("/Box", 1.0)
    made.stage.Save()
    words = ["convert", str(tmp_path / "scene.usda"), str(tmp_path / "room.glb"), "--json"]
    done = CliRunner().invoke(orusd, words)
    assert json.loads(done.output)["to"] == "gltf"
    assert set(loaded) == {(adapters.EXPORTERS, "gltf")}
    assert (tmp_path / "room.glb").is_file()


def test_what_is_not_drawn_is_told(composed_bodies: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(composed_bodies))
    report = GltfExporter().convert(stage, tmp_path / "room.glb", {})
    rows = {prim for prim, _, _ in report.rows}
    shown = (UsdGeom.Gprim, UsdGeom.Camera)
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        seen = UsdGeom.Imageable(prim).ComputePurpose() != "guide" if prim.IsA(shown[0]) else True
        if (any(map(prim.IsA, shown)) and seen) or prim.HasAPI(UsdLux.LightAPI):
            assert str(prim.GetPath()) in rows
    joints = [str(p.GetPath()) for p in stage.Traverse() if "Joint" in p.GetTypeName()]
    assert joints and rows >= set(joints)
    reasons = {reason for _, outcome, reason in report.rows if outcome == "skipped"}
    assert any("purpose is guide" in reason for reason in reasons)


def test_viewers_that_cannot_expose_get_light_that_is_exposed(export: Export) -> None:
    made = Stage()
    ball = UsdLux.SphereLight.Define(made.stage, "/Ball")
    ball.CreateIntensityAttr(1000.0)
    define_mesh_light(made.box("/Bulb", 0.1).GetPrim(), nits=5000.0)
    glow = made.material("/Glow", emissive=(300.0, 200.0, 100.0))
    made.box("/Sign", 0.1, material=glow)
    made.camera((0, -4, 1), (0, 0, 1))
    UsdGeom.Camera(made.stage.GetPrimAtPath("/Camera")).CreateExposureAttr(-8.0)

    def light(**options: str) -> list[float]:
        glb, _ = export(made.stage, options)
        strong = "KHR_materials_emissive_strength"
        lamps_there = [item["intensity"] for item, _ in lamps(glb).values()]
        glows = [
            max(item.get("emissiveFactor", [0.0]))
            * item.get("extensions", {}).get(strong, {"emissiveStrength": 1.0})["emissiveStrength"]
            for item in glb.json["materials"]
        ]
        return [*sorted(lamps_there), *sorted(glows)]

    plain = np.array(light())
    assert np.allclose(light(exposure="camera"), plain * 2.0**-8, rtol=1e-6)
    assert np.allclose(light(exposure="-3.5"), plain * 2.0**-3.5, rtol=1e-6)
    for wrong in ("bright", "nan", "99"):
        with pytest.raises(InputError, match="exposure"):
            light(exposure=wrong)
