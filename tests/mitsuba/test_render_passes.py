"""Channels of light, as a session gives them: sums, wholes, and how long a render pass goes on."""

from typing import Any

import numpy as np
import pytest
from pxr import Gf, UsdLux

from openrooms_usd.render import RenderRequest
from openrooms_usd.render.estimates import relative_mse, robust_error
from tests.opening import open_with

KINDS = ("radiance", "emission", "direct", "indirect")


@pytest.fixture
def session(build: Any, lit: Any) -> Any:
    """A grey room with two lamps of different strength and colour, seen by its camera."""
    from orusd_mitsuba import MitsubaRenderer

    made = build()
    made.box("/Room", 4.0, inside=True, material=made.material("/Grey", base_color=(0.5,) * 3))
    for number, (x, color) in enumerate([(-1.0, (1.0, 0.6, 0.3)), (1.0, (0.3, 0.6, 1.0))]):
        light = UsdLux.RectLight.Define(made.stage, f"/Lamp_{number}")
        light.CreateIntensityAttr(100.0 * (number + 1))
        light.CreateColorAttr(Gf.Vec3f(*color))
        light.CreateWidthAttr(0.5)
        light.CreateHeightAttr(0.5)
        light.AddTranslateOp().Set(Gf.Vec3d(x, 0, 1.5))
    made.camera((0, -1.8, 0.5), (0, 1, 0.3), fov=80)
    del lit
    return open_with(MitsubaRenderer(), made.stage)


def images(session: Any, *channels: str, **how: Any) -> dict[str, Any]:
    request = RenderRequest("/Camera", channels, 32, 24, **({"samples": 32} | how))
    found: dict[str, Any] = session.render(request).images
    return found


def test_kinds_and_lights_add_up_to_the_picture(session: Any) -> None:
    found = images(session, *KINDS, "radiance_i")
    lights = [image for name, image in found.items() if name.startswith("radiance_")]
    assert len(lights) == len(session.lights) >= 2
    whole = found["radiance"].pixels
    for parts in (lights, [found[name] for name in KINDS[1:]]):
        total = sum(part.pixels.astype(np.float64) for part in parts)
        np.testing.assert_allclose(total, whole, rtol=1e-5, atol=1e-6)


def test_irradiance_is_the_sum_of_its_kinds_and_of_its_lights(session: Any) -> None:
    found = images(
        session, "irradiance", "irradiance_direct", "irradiance_indirect", "irradiance_i"
    )
    whole = found["irradiance"].pixels
    straight, scattered = (found[f"irradiance_{kind}"].pixels for kind in ("direct", "indirect"))
    np.testing.assert_allclose(straight + scattered, whole, rtol=1e-5)
    lights = [found[f"irradiance_{number}"].pixels for number in range(len(session.lights))]
    np.testing.assert_allclose(np.sum(lights, axis=0, dtype=np.float64), whole, rtol=1e-5)


def test_every_light_has_its_own_color(session: Any) -> None:
    found = images(session, "radiance_i")
    ratios = []
    for number in range(2):
        red, _, blue = found[f"radiance_{number}"].pixels.mean(axis=(0, 1))
        ratios.append(red / blue)
    # Grey walls keep the colour of what lights them.
    assert sorted(ratios) == pytest.approx([0.3, 1.0 / 0.3], rel=1e-3)


def test_each_channel_tells_the_error_that_it_has(session: Any) -> None:
    """Against many more samples, with another seed."""
    names = ("radiance", "direct", "indirect", "irradiance", "radiance_i")
    few, many = (images(session, *names, samples=n, seed=n) for n in (32, 2048))
    for name, image in few.items():
        truth = many[name].pixels.astype(np.float64)
        if name.endswith("_2"):  # Nothing comes in from elsewhere.
            assert not truth.any() and not image.pixels.any() and image.error is None
            continue
        made, robust = (f(image.pixels, truth) for f in (relative_mse, robust_error))
        assert 0.5 * made <= image.error, name
        assert 0.5 * robust <= image.robust_error <= 3.0 * robust, name


def test_an_error_that_is_asked_for_is_reached_by_each_render_pass(session: Any) -> None:
    found = images(session, "radiance", "irradiance", samples=None, error=3e-2)
    assert all(image.robust_error <= 3e-2 for image in found.values())


def test_equal_seeds_give_equal_bits_whatever_else_is_asked_for(session: Any) -> None:
    """Of what comes from the same pass."""
    alone = images(session, "radiance")["radiance"].pixels
    among = images(session, *KINDS, "depth")["radiance"].pixels
    assert np.array_equal(alone, among)
    some = images(session, "irradiance", "radiance")["irradiance"].pixels
    whole = images(session, "irradiance", "diffuse", "specular", *KINDS)["irradiance"].pixels
    assert np.array_equal(some, whole)
    assert not np.array_equal(alone, images(session, "radiance", seed=9)["radiance"].pixels)
