"""What a backend cannot have is said before it is tried."""

from pathlib import Path

import pytest
from pxr import Usd, UsdGeom, UsdLux

from openrooms_usd.errors import RenderError
from openrooms_usd.rendering.scene import gathering
from openrooms_usd.rendering.scene.translate import translate
from orusd_mitsuba import limits
from tests.crowd import crowd
from tests.mitsuba.rendering import session_of, shown


def test_instances_that_do_not_fit_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gathering, "LEAST_SAVED_TRIANGLES", 1)
    monkeypatch.setattr(gathering, "_LEAST_SAVED_BY_ONE", 1)
    scene = translate(crowd(str(tmp_path / "none.png")).stage)
    # Sides, lids and tips of eight boxes.
    expanded = 8 * (10 + 2 + 4)
    assert limits.instances_advice(scene) == ""
    monkeypatch.setattr(limits, "_MANY_EXPANDED_TRIANGLES", expanded)
    assert "--variant scalar" in limits.instances_advice(scene)
    monkeypatch.setattr(limits, "_MANY_EXPANDED_TRIANGLES", expanded + 1)
    assert limits.instances_advice(scene) == ""
    monkeypatch.setattr(limits, "_MANY_EXPANDED_TRIANGLES", 1)
    monkeypatch.setattr(limits, "_memory", lambda: 100.0 * expanded)
    with pytest.raises(RenderError) as caught:
        limits.instances_advice(scene)
    assert "--variant scalar" in str(caught.value.remedy)


def test_where_nobody_chooses_very_many_instances_are_kept(
    vectorized: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if "llvm" not in vectorized:
        pytest.skip("cuda expands instances whatever their number")
    monkeypatch.setattr(gathering, "LEAST_SAVED_TRIANGLES", 1)
    monkeypatch.setattr(gathering, "_LEAST_SAVED_BY_ONE", 1)
    stage = crowd(str(tmp_path / "none.png")).stage
    few = session_of(stage).session
    assert "llvm" in few.backend and "kept" not in few.advice
    monkeypatch.setattr(limits, "_MANY_EXPANDED_TRIANGLES", 1)
    many = session_of(stage).session
    assert "scalar" in many.backend and "keeps instances" in many.advice
    asked = session_of(stage, variant="llvm").session
    assert "llvm" in asked.backend and "expanded" in asked.advice


def test_a_camera_that_sees_nothing_at_all_gives_black(variant: str) -> None:
    """Between clipping planes, too, where rays are traced one by one."""
    stage = Usd.Stage.CreateInMemory()
    UsdLux.DomeLight.Define(stage, "/Sky").CreateIntensityAttr(0.0)
    camera = UsdGeom.Camera.Define(stage, "/Camera")
    camera.CreateClippingRangeAttr((5.0, 10.0))
    opened = session_of(stage, variant=variant)
    images = shown(opened, "radiance", "depth", "instance", width=8, height=6, samples=2).images
    assert not any(image.pixels.any() for image in images.values())
