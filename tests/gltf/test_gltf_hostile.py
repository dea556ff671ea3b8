"""Stages that no program of ours would write: nothing raises, and what is written is in bounds."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux

from openrooms_usd.usd.lights import define_mesh_light
from openrooms_usd.usd.surfaces import Texture
from orusd_gltf import GltfExporter
from tests.gltf.reading import read
from tests.small import Stage

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
