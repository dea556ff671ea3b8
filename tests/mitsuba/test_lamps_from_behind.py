"""Lamps are there for who sees their front: cameras and paths go through their backs."""

from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering import RenderRequest
from tests import small
from tests.mitsuba.rendering import session_of
from tests.small import square


def before_a_wall(*, light: bool = True) -> Any:
    """A camera that looks at a grey wall, in even light."""
    made = small.Stage()
    wall = square((0, 2, 0), 5, "-Y")
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
    made.light("Sphere", "/Ball", nits, radius=0.5)


def panel(made: Any, nits: float, turn: float) -> None:
    """A panel between the camera and the wall."""
    made.light("Rect", "/Panel", nits, at=(0, 1, 0), turn=(turn, 0, 0), width=2.0, height=2.0)


def facing_the_wall(made: Any, nits: float) -> None:
    panel(made, nits, 90.0)


def test_a_camera_in_a_ball_of_light_sees_the_room(open_stage: Any) -> None:
    plain, inside = before_a_wall(), before_a_wall()
    ball(inside, 0.0)
    names = "radiance", "depth", "part"
    found = seen(inside.stage, open_stage, *names)
    expected = seen(plain.stage, open_stage, *names)
    assert found["depth"] == pytest.approx(expected["depth"], abs=1e-4)
    # The front of the ball hides (r / d)^2 of the dome's light from the wall.
    hidden = (0.5 / 2.0) ** 2
    assert found["radiance"].mean() == pytest.approx(
        (1.0 - hidden) * expected["radiance"].mean(), rel=0.02
    )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("shape", [ball, facing_the_wall])
def test_it_lights_the_room_all_the_same(open_stage: Any, shape: Any) -> None:
    """As far as a lamp that is behind the camera would: in the middle of the wall L F / pi."""
    made = before_a_wall(light=False)
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


def test_from_the_front_it_is_a_surface(open_stage: Any) -> None:
    made = before_a_wall()
    panel(made, 10.0, -90.0)
    found = seen(made.stage, open_stage, "radiance", "depth")
    assert found["radiance"] == pytest.approx(np.full_like(found["radiance"], 10.0), rel=1e-4)
    assert found["depth"] == pytest.approx(np.ones_like(found["depth"]), abs=1e-4)


@pytest.mark.usefixtures("vectorized")
def test_who_sees_its_back_is_lit_through_it() -> None:
    """A panel that shows a floor its back leaves the light of a lamp behind; its front does not."""

    def lit(turn: float | None) -> float:
        made = small.Stage()
        floor = square((0, 0, 0), 1)
        made.quad("/Floor", floor, material=made.material("/White", base_color=(1.0,) * 3))
        made.light("Disk", "/Lamp", 100.0, at=(0, 0, 2), radius=0.2)
        if turn is not None:
            made.light(
                "Rect", "/Between", 0.0, at=(0, 0, 1), turn=(turn, 0, 0), width=4.0, height=4.0
            )
        made.camera((0, 0, 0.9), (0, 0, 0), up=(0, 1, 0), fov=20.0)
        opened = session_of(made.stage)
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
