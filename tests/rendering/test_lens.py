"""Depth of field on request: the camera that a renderer gets."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.contract import Image, RenderRequest
from openrooms_usd.rendering.driver import render_stage
from openrooms_usd.usd.cameras import PinholeCamera, define_camera
from tests.opening import open_with


def camera_for(f_stop: float | None, lens: tuple[float, float] | None = None) -> PinholeCamera:
    """What a renderer gets for a camera 2 m before a wall."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    wall = UsdGeom.Mesh.Define(stage, "/wall")
    wall.CreatePointsAttr([(-9, -9, 2), (9, -9, 2), (9, 9, 2), (-9, 9, 2)])
    wall.CreateFaceVertexCountsAttr([4])
    wall.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    define_camera(stage, "/eye", world_from_camera=np.eye(4), resolution=(8, 6), lens=lens)
    given: list[PinholeCamera] = []

    def render(camera: PinholeCamera, *rest: Any) -> dict[str, Image]:
        given.append(camera)
        return {"radiance": Image(np.zeros((6, 8, 3), np.float32), 1, 0.0, None)}

    renderer: Any = SimpleNamespace(
        channels=("radiance",),
        open=lambda scene, options: SimpleNamespace(tracer=None, advice="", render=render),
    )
    request = RenderRequest("/eye", ("radiance",), 8, 6, samples=1)
    open_with(renderer, stage, f_stop=f_stop).render(request)
    return given[0]


def test_a_lens_on_request_is_focused_on_the_middle_or_as_the_camera_says() -> None:
    assert camera_for(None).lens_radius == 0.0
    found = camera_for(2.8)
    # 60 degrees on film 36 mm wide: a focal length of 31.2 mm.
    assert found.lens_radius == pytest.approx(0.018 / np.tan(np.radians(30)) / 2.8 / 2, rel=1e-5)
    assert found.focus_distance == pytest.approx(2.0)
    kept = camera_for(4.0, lens=(8.0, 0.7))
    assert (kept.f_stop, kept.focus_distance) == pytest.approx((4.0, 0.7))


def test_an_f_stop_that_is_no_lens_is_refused(renderer, scene, tmp_path) -> None:
    with pytest.raises(InputError, match="must be between"):
        render_stage(scene, tmp_path / "out", RenderSettings(f_stop=0.0))


def test_the_lens_that_was_asked_for_is_in_the_manifest(renderer, scene, tmp_path) -> None:
    asked = RenderSettings(f_stop=2.0)
    assert render_stage(scene, tmp_path / "out", asked).manifest["f_stop"] == 2.0
    assert "f_stop" not in render_stage(scene, tmp_path / "plain").manifest
