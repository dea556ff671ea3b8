"""Whatever draws a stage opens it in one place, prepared alike."""

import ast
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import UsdGeom, UsdShade

import openrooms_usd as ou
from openrooms_usd import adapters
from openrooms_usd.comparison import driver as comparison
from openrooms_usd.comparison.photographs import Photographs
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import RenderError
from openrooms_usd.physics.world import World
from openrooms_usd.rendering.bake.baking import bake_stage
from openrooms_usd.rendering.driver import render_stage
from openrooms_usd.rendering.paths.rendering import render_path
from openrooms_usd.rendering.probes import probe_stage
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.simulation.robot_cameras import RobotCameras
from openrooms_usd.view.tracing import Trace, Tracing
from tests.usd.test_moments import puppet

ROOT = Path(__file__).parents[2]
RED = (0.8, 0.1, 0.1)
MATERIALX = """<?xml version="1.0"?>
<materialx version="1.38" colorspace="lin_rec709">
  <standard_surface name="SR" type="surfaceshader">
    <input name="base" type="float" value="1"/>
    <input name="base_color" type="color3" value="0.8, 0.1, 0.1"/>
  </standard_surface>
  <surfacematerial name="red" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="SR"/>
  </surfacematerial>
</materialx>
"""
SCENE = "openrooms_usd.rendering.scene"
MOMENT = 10.0  # of the puppet's animation: it is bent, and four metres up
ASKED = RenderSettings(renderer="spy", time_code=MOMENT, texture_side=8, resolution=(16, 12))


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    """A skinned mesh with a material of MaterialX, which moves, and no light."""
    (tmp_path / "looks.mtlx").write_text(MATERIALX)
    made = puppet()
    looks = made.DefinePrim("/World/Looks")
    looks.GetReferences().AddReference("./looks.mtlx", "/MaterialX/Materials")
    mesh = made.GetPrimAtPath("/World/Puppet/Mesh")
    UsdShade.MaterialBindingAPI.Apply(mesh)
    mesh.CreateRelationship("material:binding").SetTargets(["/World/Looks/red"])
    UsdGeom.Camera.Define(made, "/World/Eye").AddTranslateOp().Set((7, 0, 20))
    made.GetRootLayer().Export(str(tmp_path / "stage.usda"))
    return tmp_path / "stage.usda"


class Spy:
    """A renderer that keeps what it is given to render, and goes no further."""

    channels = ("radiance",)
    options: Mapping[str, str] = {}

    def __init__(self) -> None:
        self.scenes: list[Scene] = []

    def open(self, scene: Scene, options: Mapping[str, str]) -> Any:
        self.scenes.append(scene)
        raise RenderError("seen")


@pytest.fixture
def spy(monkeypatch: pytest.MonkeyPatch) -> Spy:
    made, real = Spy(), adapters.load

    def load(group: str, name: str) -> Any:
        return made if (group, name) == (adapters.RENDERERS, "spy") else real(group, name)

    monkeypatch.setattr(adapters, "load", load)
    return made


def _compare(stage: Path, out: Path, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(comparison, "read_photographs", lambda *given: Photographs((), None, ()))
    patch.setattr(comparison, "chosen_frames", lambda *given: ())
    comparison.compare_stage(stage, out, ASKED)


def _trace(stage: Path, out: Path, patch: pytest.MonkeyPatch) -> None:
    pose = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    asked = Trace(world_from_camera=pose, focal=1.0, width=16, height=16)
    tracing = Tracing(stage, ASKED)
    tracing.start(asked)
    assert tracing._thread
    tracing._thread.join()
    raise RenderError(tracing._told["error"]["message"])


def _robot(stage: Path, out: Path, patch: pytest.MonkeyPatch) -> None:
    cameras = RobotCameras(stage, World(()), ASKED)
    simulation: Any = type("Still", (), {"links": lambda *a: {}, "poses": lambda *a: {}})()
    cameras.see(simulation, {"eye": np.eye(4)}, ("radiance",))


ENTRANCES: dict[str, Callable[[Path, Path, pytest.MonkeyPatch], Any]] = {
    "render": lambda stage, out, patch: render_stage(stage, out, ASKED),
    "python": lambda stage, out, patch: ou.open_renderer(stage, settings=ASKED),
    "film": lambda stage, out, patch: render_path(stage, out, "walk", ASKED),
    "probe": lambda stage, out, patch: probe_stage(stage, out, ASKED, at=[(0, 0, 0)]),
    "bake": lambda stage, out, patch: bake_stage(stage, out, ASKED),
    "compare": _compare,
    "view": _trace,
    "robot": _robot,
}


@pytest.mark.parametrize("entrance", ENTRANCES)
def test_every_entrance_sees_the_same_scene(
    entrance: str, stage: Path, spy: Spy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if entrance == "film":
        pytest.importorskip("av")
    with pytest.raises(RenderError, match="seen"):
        ENTRANCES[entrance](stage, tmp_path / "out", monkeypatch)
    (scene,) = spy.scenes
    (patch,) = scene.patches
    # MaterialX: not the grey of what has no material.
    assert np.allclose(patch.surface.base_color, RED, atol=1e-6)
    # The pose at that time: the rest pose ends two metres up, and begins on the ground.
    assert patch.triangles.corners[..., 2].min() > 3.9
    # A default light, where the stage has none.
    assert scene.environment is not None


def test_nothing_else_opens_a_stage_for_rendering() -> None:
    """No module but the door translates a stage, or lets a renderer open what comes of it."""
    translating = {
        "openrooms_usd/rendering/opening.py",
        # These write scenes, and draw none.
        "converters/orusd_mitsuba/export/exporter.py",
        "converters/orusd_openrooms/scenes/export.py",
    }
    loading = {
        "openrooms_usd/rendering/opening.py",
        # These only ask what a renderer gives, and whether it works here.
        "openrooms_usd/rendering/given.py",
        "openrooms_usd/doctor.py",
    }
    found: dict[str, set[str]] = {"translate": set(), "load": set()}
    sources = [*(ROOT / "openrooms_usd").rglob("*.py"), *(ROOT / "converters").rglob("*.py")]
    for path in sources:
        name, text = path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")
        if "adapters.RENDERERS" not in text and "translate" not in text:
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom) and node.module == f"{SCENE}.translate":
                found["translate"].add(name)
            if isinstance(node, ast.Call) and ast.unparse(node).startswith(
                "adapters.load(adapters.RENDERERS"
            ):
                found["load"].add(name)
    assert found == {"translate": translating, "load": loading}
