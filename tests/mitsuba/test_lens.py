"""Cameras with a lens: what is out of focus is as blurred as a thin lens blurs it."""

from typing import Any

import numpy as np
import pytest
from pxr import Usd

from tests import small
from tests.small import square

FOCUS_M, EDGE_M, RADIUS_M = 1.0, 2.0, 0.05
WIDTH, HEIGHT = 64, 8


@pytest.fixture
def edge() -> Usd.Stage:
    """Black on the left, glowing on the right, behind the plane of focus."""
    made = small.Stage()
    black = made.material("/Black", base_color=(0, 0, 0))
    bright = made.material("/Bright", base_color=(0, 0, 0), emissive=(1, 1, 1))
    made.quad("/Left", square((-4.5, 0, 0), (4.5, 9)), material=black)
    made.quad("/Right", square((4.5, 0, 0), (4.5, 9)), material=bright)
    made.dome(radiance=0.0)
    path = made.camera((0, 0, EDGE_M), (0, 0, 0), up=(0, 1, 0), fov=40, aspect=WIDTH / HEIGHT)
    camera = made.stage.GetPrimAtPath(path)
    # Apertures and focal lengths are in tenths of a unit, here of a metre.
    focal_m = camera.GetAttribute("focalLength").Get() / 10
    camera.GetAttribute("fStop").Set(focal_m / (2 * RADIUS_M))
    camera.GetAttribute("focusDistance").Set(FOCUS_M)
    return made.stage


@pytest.mark.parametrize("channel", ["radiance", "radiance_i"])
def test_an_edge_is_spread_over_the_circle_of_confusion(
    edge: Usd.Stage, shoot: Any, variant: str, channel: str
) -> None:
    """Its diameter in pixels is 2 r f |1/focus - 1/depth|."""
    if variant == "scalar" and channel != "radiance":
        pytest.skip("the scalar backend has radiance alone")
    # Other channels make other passes.
    asked = (channel, "irradiance") if channel == "radiance_i" else (channel,)
    view = shoot(edge, *asked, "base_color", width=WIDTH, height=HEIGHT, samples=512, bounces=1)
    radius_px = RADIUS_M * view.K[0, 0] * abs(1 / FOCUS_M - 1 / EDGE_M)
    assert radius_px > 2
    fine = (np.arange(16 * WIDTH) + 0.5) / 16 - WIDTH / 2
    x = np.clip(fine / radius_px, -1, 1)
    spread = 0.5 + (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    expected = spread.reshape(WIDTH, 16).mean(axis=1)
    name = channel.replace("_i", "_0")
    found = view.images[name].pixels[..., 1].mean(axis=0)
    np.testing.assert_allclose(found, expected, atol=0.015)


def test_ground_truth_is_that_of_a_pinhole(edge: Usd.Stage, shoot: Any, variant: str) -> None:
    view = shoot(edge, "emission_mask", "depth", width=WIDTH, height=HEIGHT)
    np.testing.assert_array_equal(
        view.images["emission_mask"].pixels[0, :, 0], np.arange(WIDTH) >= WIDTH // 2
    )
    np.testing.assert_allclose(view.images["depth"].pixels, EDGE_M, rtol=1e-5)


def test_what_is_in_focus_is_sharp(edge: Usd.Stage, shoot: Any, variant: str) -> None:
    edge.GetPrimAtPath("/Camera").GetAttribute("focusDistance").Set(EDGE_M)
    found = shoot(edge, "radiance", width=WIDTH, height=HEIGHT, samples=16, bounces=1)
    row = found.images["radiance"].pixels[..., 0]
    np.testing.assert_allclose(row, (np.arange(WIDTH) >= WIDTH // 2)[None].repeat(HEIGHT, 0))
