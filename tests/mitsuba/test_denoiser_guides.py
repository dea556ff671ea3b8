"""What denoisers are guided by: patterns finer than pixels are their mean, not what centres see."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, Texture
from tests import small
from tests.pictures import save_picture
from tests.small import square

# Stripes a pixel; not a whole number, so that centres see a slow beat.
STRIPES_A_PIXEL = 1.07
WIDTH, HEIGHT = 32, 24
SLOPE = 0.6


@pytest.fixture
def striped(tmp_path: Path) -> Usd.Stage:
    """A quad that fills the picture, black and white in stripes, whose normals lean to and fro."""
    count = round(WIDTH * STRIPES_A_PIXEL)
    side = np.tile(np.repeat([0, 1], 8), count)[None, :, None].repeat(2, axis=0)
    color = (side * np.full(3, 255)).astype(np.uint8)
    lean = np.where(side > 0, SLOPE, -SLOPE)
    normal = np.concatenate([lean, 0 * lean, np.sqrt(1 - lean**2)], axis=2)
    coded = np.round(127.5 * (normal + 1)).astype(np.uint8)
    made = small.Stage()
    relief = Texture(
        save_picture(tmp_path / "normal.png", coded),
        "rgb",
        "raw",
        scale=NORMAL_SCALE,
        bias=NORMAL_BIAS,
    )
    paper = made.material(
        "/Paper", base_color=Texture(save_picture(tmp_path / "color.png", color)), normal=relief
    )
    made.quad("/Quad", square((0, 0, 0), (4, 3)), material=paper)
    made.camera((0, 0, 6), (0, 0, 0), up=(0, 1, 0), fov=60)
    made.dome()
    return made.stage


def test_guides_are_means_over_pixels_and_channels_are_not(
    shoot: Any, striped: Usd.Stage, variant: str
) -> None:
    view = shoot(
        striped, "base_color", "normal", samples=1, guides=True, width=WIDTH, height=HEIGHT
    )
    inner = slice(3, -3), slice(3, -3)
    seen, mean = (
        np.asarray(found[inner])
        for found in (view.images["base_color"].pixels, view.guides["base_color"])
    )
    assert seen.min() < 0.01 and seen.max() > 0.99
    # A backend that calls Python for each surface leaves it to the core, which asks four places.
    off = 0.08 if variant == "llvm" else 0.5
    np.testing.assert_allclose(mean, 0.5, atol=off)
    assert mean.std() < 0.6 * seen.std()
    upright = view.guides["normal"][inner]
    # Between two texels normals are interpolated, and stand upright.
    np.testing.assert_allclose(upright[..., 2], np.sqrt(1 - SLOPE**2), atol=off / 2)
    assert np.abs(upright[..., 0]).max() < 2 * off * SLOPE + 0.02


def test_a_lens_softens_guides_too(shoot: Any, variant: str) -> None:
    """Else the denoiser would sharpen what is out of focus."""
    if variant == "scalar":
        pytest.skip("the core's fallback looks through pinholes")
    made = small.Stage()
    black, white = (made.material(f"/Grey{n}", base_color=(n, n, n)) for n in (0, 1))
    made.quad("/Left", square((-4.5, 0, 0), (4.5, 9)), material=black)
    made.quad("/Right", square((4.5, 0, 0), (4.5, 9)), material=white)
    made.dome()
    path = made.camera((0, 0, 2), (0, 0, 0), up=(0, 1, 0))
    camera = made.stage.GetPrimAtPath(path)
    soft = []
    for stop in (0.0, 0.2):
        camera.GetAttribute("fStop").Set(stop)
        camera.GetAttribute("focusDistance").Set(1.0)
        base = shoot(made.stage, "base_color", samples=1, guides=True).guides["base_color"]
        soft.append(int(((base > 0.05) & (base < 0.95)).sum()))
    assert soft[0] == 0 and soft[1] > 100
