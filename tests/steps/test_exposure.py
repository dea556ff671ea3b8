"""What cameras are exposed for, against the closed form of an integrating sphere."""

import math
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.composing import compose_room
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.steps.cameras.step import room_exposure
from openrooms_usd.usd.cameras import read_camera
from openrooms_usd.usd.light.lights import define_dome

# A room of 4 m by 3 m by 2.5 m with a window of 1.5 m by 1 m to -Y.
BOUNDS = 2 * (4 * 3 + 4 * 2.5 + 3 * 2.5)
WINDOW = 1.5
ROOM = """\
layout:
  polygon: [[0, 0], [4, 0], [4, 3], [0, 3]]
  height: 2.5
  openings: [{name: way, kind: window, wall: 0, at: 2, width: 1.5, height: 1}]
furniture: {objects: [%s]}
materials: {resolution: 16}
lights: {environment: {illuminance: %g}, lamps: {%s}}
cameras: {resolution: [16, 12], views: [{name: eye, eye: [1, 1, 1.5], target: [3, 2, 1]}, %s]}
"""
LAMP = "{name: lamp, category: ceiling_lamp, at: [2, 1.5]}"


def compose(folder: Path, lux: float, *, lumen: float | None = None, more: str = "") -> Usd.Stage:
    lamps = ("", "") if lumen is None else (LAMP, f"lamp: {{lumen: {lumen}}}")
    (folder / "room.yaml").write_text(ROOM % (lamps[0], lux, lamps[1], more))
    compose_room(folder / "room.yaml", folder / "out", workers=1)
    stage = Usd.Stage.Open(str(folder / "out/scene.usda"))
    stage.Reload()
    return stage


def expected(daylight: float, lamps: float = 0.0) -> float:
    """Of lumen: half of daylight gets in, and surfaces send half of their light back."""
    nits = (0.5 * daylight + lamps) / BOUNDS * 0.5 / (1 - 0.5) / math.pi
    return 0.27 / nits


def test_a_window_lets_in_the_light_of_its_side_of_the_sky(tmp_path: Path) -> None:
    """Of a constant dome, pi L lux fall on any plane."""
    stage = compose(tmp_path, 10_000)
    assert room_exposure(stage) == pytest.approx(expected(10_000 * WINDOW), rel=1e-4)


def test_lamps_and_sky_add_up(tmp_path: Path) -> None:
    stage = compose(tmp_path, 500, lumen=1200)
    assert room_exposure(stage) == pytest.approx(expected(500 * WINDOW, 1200), rel=1e-4)


def test_in_the_dark_there_is_nothing_to_expose_for(tmp_path: Path) -> None:
    stage = compose(tmp_path, 0)
    assert room_exposure(stage) is None
    camera = UsdGeom.Camera(stage.GetPrimAtPath(f"{names.CAMERAS}/eye"))
    assert not camera.GetExposureAttr().HasAuthoredValue()


@pytest.mark.parametrize("rotation", [0.0, 37.0, 90.0, 180.0])
def test_pictures_of_the_sky_are_summed_over_what_the_window_faces(
    tmp_path: Path, rotation: float
) -> None:
    """Half a sky: luminous where it looks to -Y before it is turned."""
    stage = compose(tmp_path, 1.0)
    height = 128
    columns = (np.arange(2 * height) + 0.5) / (2 * height)
    pixels = np.zeros((height, 2 * height, 3), np.float32)
    pixels[:, np.abs(columns - 0.5) < 0.25] = 1000.0
    write_exr(tmp_path / "half.exr", pixels)
    define_dome(
        stage,
        names.ENVIRONMENT,
        radiance=(2, 2, 2),
        texture=str(tmp_path / "half.exr"),
        rotation=rotation,
    )
    stage.GetPrimAtPath(names.ENVIRONMENT).GetAttribute("inputs:intensity").Set(2.0)
    # A lune of a dome before a vertical plane, turned by a: pi L (1 + cos a) / 2.
    lux = math.pi * 2000.0 * (1 + math.cos(math.radians(rotation))) / 2
    found = room_exposure(stage)
    if rotation == 180.0:
        assert found is None or found > 1e3 * expected(math.pi * 2000.0 * WINDOW)
    else:
        assert found == pytest.approx(expected(lux * WINDOW), rel=0.01)


def test_every_camera_carries_it_and_previews_are_fitted_all_the_same(tmp_path: Path) -> None:
    more = "{name: metered, exposure_value: 7, eye: [1, 1, 1.5], target: [3, 2, 1]}"
    stage = compose(tmp_path, 10_000, more=more)
    eye, metered = (stage.GetPrimAtPath(f"{names.CAMERAS}/{name}") for name in ("eye", "metered"))
    guess = UsdGeom.Camera(eye).GetExposureAttr()
    assert guess.Get() == pytest.approx(math.log2(expected(10_000 * WINDOW)), abs=0.051)
    assert read_camera(eye, 16, 12).exposure is None
    assert read_camera(metered, 16, 12).exposure == pytest.approx(1 / (1.2 * 2**7), rel=1e-6)
    stage.SetEditTarget(stage.GetSessionLayer())
    guess.Set(-5.0)
    assert read_camera(eye, 16, 12).exposure == pytest.approx(2.0**-5)
    stage.GetSessionLayer().Clear()
    eye.GetAttribute("exposure:iso").Set(200.0)
    assert read_camera(eye, 16, 12).exposure == pytest.approx(2.0 * 2.0 ** guess.Get())


@pytest.mark.slow
@pytest.mark.parametrize(("lux", "lumen"), [(15_000, None), (0, 1500.0), (1500, 1500.0)])
def test_a_picture_at_this_exposure_is_neither_black_nor_white(
    tmp_path: Path, lux: float, lumen: float | None
) -> None:
    """Within two stops of what the picture itself asks for."""
    mitsuba = pytest.importorskip("orusd_mitsuba")
    from openrooms_usd.rendering import RenderRequest
    from openrooms_usd.rendering.color import fitted_exposure
    from tests.opening import open_with

    stage = compose(tmp_path, lux, lumen=lumen)
    request = RenderRequest(f"{names.CAMERAS}/eye", ("radiance",), width=64, height=48, samples=64)
    view = open_with(mitsuba.MitsubaRenderer(), stage, {}).render(request)
    fitted = fitted_exposure(view.images["radiance"].pixels)
    assert abs(math.log2(room_exposure(stage) / fitted)) < 2.0  # type: ignore[operator]
