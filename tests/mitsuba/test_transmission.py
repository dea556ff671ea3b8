"""Sheets that pass part of the light: closed forms on both sides, and energy that is kept."""

import math
from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering.scene.surfaces import SurfaceReader
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture
from orusd_mitsuba import variants
from orusd_mitsuba.export.exporter import export_scene
from tests import small
from tests.pictures import save_picture
from tests.small import square

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
CLOTH = (0.5, 0.4, 0.2)
PASSED = 0.3


def passed_color(base: tuple[float, ...], transmission: float) -> np.ndarray:
    """The hue of the base colour at the luminance that the transmission says."""
    hue = np.array(base) / float(np.array(base) @ LUMINANCE)
    return hue * transmission


def sheet(*, eye: tuple[float, float, float], **inputs: Any) -> Any:
    """A sheet in the plane y = 0 that fills the picture."""
    made = small.Stage()
    material = made.material("/Cloth", **({"base_color": CLOTH, "transmission": PASSED} | inputs))
    corners = square((0, 0, 0), 50, "-Y")
    made.quad("/Sheet", corners, material=material)
    made.camera(eye, (0, 0, 0), fov=40)
    return made


def agrees(pixels: np.ndarray, expected: np.ndarray) -> bool:
    """Whether the picture's mean lies within its own noise of what is expected."""
    values = pixels.reshape(-1, 3).astype(np.float64)
    noise = values.std(axis=0) / math.sqrt(len(values))
    return bool((np.abs(values.mean(axis=0) - expected) <= 4 * noise + 1e-4 * expected).all())


@pytest.mark.parametrize("eye", [(0.4, -3.0, 0.5), (0.4, 3.0, 0.5)], ids=["front", "back"])
def test_in_even_light_a_sheet_shows_what_it_reflects_and_passes(
    shoot: Any, eye: tuple[float, float, float]
) -> None:
    made = sheet(eye=eye)
    made.dome(radiance=10.0)
    pixels = shoot(made.stage, "radiance", samples=64, bounces=1).images["radiance"].pixels
    assert agrees(pixels, 10.0 * (np.array(CLOTH) + passed_color(CLOTH, PASSED)))


def test_a_white_furnace_neither_loses_nor_makes_light(shoot: Any) -> None:
    made = sheet(eye=(0.2, -3.0, 0.1), base_color=(0.4, 0.4, 0.4), transmission=0.6)
    made.dome(radiance=1.0)
    pixels = shoot(made.stage, "radiance", samples=64).images["radiance"].pixels
    assert agrees(pixels, np.ones(3))


@pytest.mark.parametrize("behind", [False, True])
def test_parallel_light_arrives_on_both_sides(shoot: Any, behind: bool) -> None:
    """Only next-event estimation can find a light without extent."""
    made = sheet(eye=(0.4, 3.0 if behind else -3.0, 0.5))
    # Shines along +Y, 30 degrees downwards.
    made.light("Distant", "/Sun", 100.0, turn=(60.0, 0, 0), angle=0.0)
    color = passed_color(CLOTH, PASSED) if behind else np.array(CLOTH)
    pixels = shoot(made.stage, "radiance", samples=16, bounces=1).images["radiance"].pixels
    expected = 100.0 * math.cos(math.radians(30.0)) / math.pi * color
    np.testing.assert_allclose(pixels.mean(axis=(0, 1)), expected, rtol=2e-3)


def test_behind_a_curtain_the_window_is_a_dimmer_even_light(shoot: Any) -> None:
    """Its radiance inside is T times the sky's, so its irradiance T times the open window's."""
    made = small.Stage()
    black = made.material("/Black", base_color=(0.0, 0.0, 0.0))
    made.quad("/Blind", square((0, 0, -4.5), (4.5, 9), "-Y"), material=black)
    cloth = made.material("/Cloth", base_color=(0.4, 0.4, 0.4), transmission=PASSED)
    made.quad("/Curtain", square((0, 0, 1), 1, "-Y"), material=cloth)
    hole = square((0, 0, 5.5), (3.5, 9), "-Y")
    made.quad("/Above", hole, material=black)
    for side in (-1, 1):
        made.quad(
            f"/Side_{side + 1}",
            [(side, 0, 0), (9 * side, 0, 0), (9 * side, 0, 2), (side, 0, 2)],
            material=black,
        )
    for name, y, x in (("Back", -9, None), ("Left", None, -9), ("Right", None, 9)):
        ends = [(-9, y), (9, y)] if x is None else [(x, -9), (x, 0)]
        corners = [(*ends[0], -9), (*ends[1], -9), (*ends[1], 9), (*ends[0], 9)]
        made.quad(f"/{name}", corners, material=black)
    for name, z in (("Floor", -9), ("Ceiling", 9)):
        corners = [(-9, -9, z), (9, -9, z), (9, 0, z), (-9, 0, z)]
        made.quad(f"/{name}", corners, material=black)
    white = made.material("/White", base_color=(1.0, 1.0, 1.0))
    # In the plane of the curtain's lower edge, a metre away from it, facing up.
    spot = square((0, -1, 0), (0.02, 0.02))
    made.quad("/Spot", spot, material=white)
    made.camera((0, -1, 1), (0, -1, 0), up=(0, 1, 0), fov=1.0, aspect=1.0)
    made.dome(radiance=1000.0)
    view = shoot(made.stage, "radiance", width=16, height=16, samples=512, bounces=2)
    expected = PASSED * 1000.0 / math.pi * _standing_rectangle(1.0, 2.0, 1.0)
    assert agrees(view.images["radiance"].pixels, np.full(3, expected))


def _standing_rectangle(half_width: float, height: float, distance: float) -> float:
    """Irradiance of a floor by an upright rectangle of unit radiance that stands on it.

    pi times the factor of Howell's Catalog of Radiation Heat Transfer Configuration Factors, B-4,
    twice: one half on either side.
    """
    X, Y = half_width / distance, height / distance
    factor = (math.atan(X) - 1.0 / math.sqrt(1.0 + Y**2) * math.atan(X / math.sqrt(1.0 + Y**2))) / (
        2.0 * math.pi
    )
    return 2.0 * math.pi * factor


def test_more_than_all_light_is_not_passed() -> None:
    surface = SurfaceReader().read(
        PreviewSurface(base_color=(0.7, 0.7, 0.7), ior=1.0, transmission=0.6)
    )
    assert surface.transmission == pytest.approx(0.3)
    assert any("taken as 0.3" in loss for loss in surface.losses)
    black = SurfaceReader().read(PreviewSurface(base_color=(0.0,) * 3, transmission=0.5))
    assert black.transmission == 0.0 and black.losses


def test_the_base_colour_channel_is_what_is_reflected(shoot: Any) -> None:
    made = sheet(eye=(0.4, -3.0, 0.5))
    view = shoot(made.stage, "base_color")
    np.testing.assert_allclose(view.images["base_color"].pixels, np.full((24, 32, 3), CLOTH))


def test_a_textured_sheet_passes_in_the_hue_of_each_texel(shoot: Any, tmp_path: Any) -> None:
    texels = np.zeros((1, 2, 3), dtype=np.float32)
    texels[0] = [[0.2, 0.3, 0.1], [0.1, 0.1, 0.4]]
    file = save_picture(tmp_path / "cloth.exr", texels)
    cloth = Texture(file, wrap_s="clamp", wrap_t="clamp")
    made = sheet(eye=(0.0, 3.0, 0.0), base_color=cloth, transmission=0.25)
    made.dome(radiance=1.0)
    view = shoot(made.stage, "radiance", "base_color", samples=64, bounces=1)
    mean = float((texels[0] @ LUMINANCE).mean())
    base = view.images["base_color"].pixels.astype(np.float64)
    ratio = view.images["radiance"].pixels.mean(axis=(0, 1)) / base.mean(axis=(0, 1))
    np.testing.assert_allclose(ratio, 1.0 + 0.25 / mean, rtol=0.01)


@pytest.mark.one_in(2)
def test_the_exported_sheet_passes_the_same(tmp_path: Any, variant: str) -> None:
    made = sheet(eye=(0.4, 3.0, 0.5))
    made.dome(radiance=10.0)
    export_scene(made.stage, tmp_path / "scene.xml", {})
    import mitsuba as mi

    mi.set_variant(variants.choose(variant).variant)
    scene = mi.load_file(str(tmp_path / "scene.xml"))
    pixels = np.array(mi.render(scene, spp=4, integrator=mi.load_dict({"type": "path"})))
    mean = pixels.reshape(-1, pixels.shape[2])[:, :3].mean(axis=0)
    expected = 10.0 * (np.array(CLOTH) + passed_color(CLOTH, PASSED))
    np.testing.assert_allclose(mean, expected, rtol=0.01)
