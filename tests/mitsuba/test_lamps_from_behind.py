"""Lamps are there for who sees their front: cameras and paths go through their backs."""

from typing import Any

import numpy as np
import pytest
from pxr import UsdLux

from openrooms_usd.render import RenderRequest
from orusd_mitsuba import MitsubaRenderer
from tests.opening import open_with


def before_a_wall(build: Any, *, light: bool = True) -> Any:
    """A camera that looks at a grey wall, in even light."""
    made = build()
    wall = [(-5, 2, -5), (5, 2, -5), (5, 2, 5), (-5, 2, 5)]
    made.quad("/Wall", wall, material=made.material("/Grey", base_color=(0.5, 0.5, 0.5)))
    made.camera((0, 0, 0), (0, 1, 0), fov=20.0)
    if light:
        made.dome(radiance=1.0)
    return made


def seen(stage: Any, open_stage: Any, *names: str, samples: int = 64) -> dict[str, np.ndarray]:
    request = RenderRequest("/Camera", names, 12, 9, samples=samples, bounces=2)
    images = open_stage(stage).render(request).images
    return {name: images[name].pixels.astype(np.float64) for name in names}


def ball(made: Any, nits: float) -> None:
    """A ball of light about the camera."""
    light = UsdLux.SphereLight.Define(made.stage, "/Ball")
    light.CreateRadiusAttr(0.5)
    light.CreateIntensityAttr(nits)


def panel(made: Any, nits: float, turn: float) -> None:
    """A panel between the camera and the wall."""
    light = UsdLux.RectLight.Define(made.stage, "/Panel")
    light.CreateWidthAttr(2.0)
    light.CreateHeightAttr(2.0)
    light.CreateIntensityAttr(nits)
    light.AddTranslateOp().Set((0, 1, 0))
    light.AddRotateXOp().Set(turn)


def facing_the_wall(made: Any, nits: float) -> None:
    panel(made, nits, 90.0)


def test_a_camera_in_a_ball_of_light_sees_the_room(build: Any, open_stage: Any) -> None:
    plain, inside = before_a_wall(build), before_a_wall(build)
    ball(inside, 0.0)
    names = "radiance", "depth", "part"
    found = seen(inside.stage, open_stage, *names)
    expected = seen(plain.stage, open_stage, *names)
    assert found["depth"] == pytest.approx(expected["depth"], abs=1e-4)
    # The front of the ball hides a part of the dome from the wall: 0.25 pi / 4 pi of 2 m, some 2 %.
    assert found["radiance"].mean() == pytest.approx(expected["radiance"].mean(), rel=0.06)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("shape", [ball, facing_the_wall])
def test_it_lights_the_room_all_the_same(build: Any, open_stage: Any, shape: Any) -> None:
    """As far as a lamp that is behind the camera would: in the middle of the wall L F / pi."""
    made = before_a_wall(build, light=False)
    shape(made, 10.0)
    found = seen(made.stage, open_stage, "radiance", samples=1024)["radiance"]
    middle = found[3:6, 5:7].mean()
    if shape is ball:
        # A ball of radius r at a distance d: E = pi L (r / d)^2.
        expected = 0.5 * 10.0 * 0.25**2
    else:
        # A square of half side a, opposite and parallel at a distance h, by Siegel and Howell.
        a = 1.0
        root = np.hypot(1.0, a)
        expected = 0.5 * 10.0 * 4.0 / (2.0 * np.pi) * 2.0 * a / root * np.arctan(a / root)
    assert middle == pytest.approx(expected, rel=0.03)


def test_from_the_front_it_is_a_surface(build: Any, open_stage: Any) -> None:
    made = before_a_wall(build)
    panel(made, 10.0, -90.0)
    found = seen(made.stage, open_stage, "radiance", "depth")
    assert found["radiance"] == pytest.approx(np.full_like(found["radiance"], 10.0), rel=1e-4)
    assert found["depth"] == pytest.approx(np.ones_like(found["depth"]), abs=1e-4)


@pytest.mark.usefixtures("vectorized")
def test_who_sees_its_back_is_lit_through_it(build: Any) -> None:
    """A panel that shows a floor its back leaves the light of a lamp behind; its front does not."""

    def lit(turn: float | None) -> float:
        made = build()
        floor = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
        made.quad("/Floor", floor, material=made.material("/White", base_color=(1.0,) * 3))
        lamp = UsdLux.DiskLight.Define(made.stage, "/Lamp")
        lamp.CreateRadiusAttr(0.2)
        lamp.CreateIntensityAttr(100.0)
        lamp.AddTranslateOp().Set((0, 0, 2))
        if turn is not None:
            between = UsdLux.RectLight.Define(made.stage, "/Between")
            between.CreateIntensityAttr(0.0)
            between.CreateWidthAttr(4.0)
            between.CreateHeightAttr(4.0)
            between.AddTranslateOp().Set((0, 0, 1))
            between.AddRotateXOp().Set(turn)
        made.camera((0, 0, 0.9), (0, 0, 0), up=(0, 1, 0), fov=20.0)
        opened = open_with(MitsubaRenderer(), made.stage)
        names = "radiance", "irradiance_direct"
        request = RenderRequest("/Camera", names, 8, 8, samples=256, bounces=2)
        images = opened.render(request).images
        radiance, direct = (float(images[name].pixels.mean()) for name in names)
        assert direct == pytest.approx(np.pi * radiance, rel=0.05, abs=1e-3)
        return radiance

    free = lit(None)
    # It emits along -Z: turned round it shows the floor its back.
    assert lit(180.0) == pytest.approx(free, rel=0.03)
    assert lit(0.0) == pytest.approx(0.0, abs=1e-6)
