"""Environments: illuminance against integrals, directions by definition, bad pictures refused."""

import math
from collections.abc import Callable
from importlib import resources
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.library.surroundings.environments import (
    directions,
    horizontal_illuminance,
    make_sky,
    read_panorama,
    scaled_to_nits,
)
from openrooms_usd.usd.shading.textures import read_texture

WEIGHTS = np.array([0.2126, 0.7152, 0.0722])


def solid_angles(height: int) -> np.ndarray:
    """(H, 1) of each pixel, exact."""
    edges = math.pi * (0.5 - np.arange(height + 1) / height)
    return np.abs(np.diff(np.sin(edges)))[:, None] * math.pi / height


@pytest.mark.parametrize("height", [1, 2, 7, 64])
def test_a_constant_sky_of_luminance_l_gives_pi_l(height: int) -> None:
    sky = np.full((height, 2 * height, 3), 1000.0)
    assert horizontal_illuminance(sky) == pytest.approx(1000.0 * math.pi)


def test_the_overcast_sky_gives_seven_ninths_of_pi_times_its_zenith() -> None:
    """CIE overcast: L = Lz (1 + 2 sin elevation) / 3, E = 7/9 pi Lz. The ground counts nothing."""
    up = directions(512)[..., 2]
    sky = np.where(up > 0, (1 + 2 * up) / 3, 50.0)[..., None] * np.ones(3)
    assert horizontal_illuminance(sky) == pytest.approx(7 / 9 * math.pi, rel=1e-4)


def test_luminance_weights_each_primary() -> None:
    for channel in range(3):
        sky = np.zeros((8, 16, 3))
        sky[..., channel] = 1.0
        assert horizontal_illuminance(sky) == pytest.approx(math.pi * WEIGHTS[channel])


def test_directions_follow_the_dome_of_the_scene() -> None:
    """The same frame as a DomeLight_1 with its pole along Z: checked through the reader."""
    from pxr import Usd, UsdGeom

    from openrooms_usd.usd.light.lights import define_dome, read_lights

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    define_dome(stage, "/Dome")
    frame = read_lights(stage)[0].world_from_light[:3, :3]
    way = directions(6)
    for row, column in ((0, 0), (2, 3), (3, 7), (5, 11)):
        lon, lat = math.pi * (1 - (column + 0.5) / 6), math.pi * (0.5 - (row + 0.5) / 6)
        local = [math.cos(lat) * math.sin(lon), math.sin(lat), math.cos(lat) * math.cos(lon)]
        np.testing.assert_allclose(way[row, column], frame @ local, atol=1e-12)
    assert way[0, :, 2].min() > 0.9


def test_the_sun_stands_where_it_should_and_adds_its_lux() -> None:
    options = {"height": 256, "sun_elevation": 50.0, "sun_azimuth": 120.0, "sun_spread": 3.0}
    with_sun = make_sky(sun_illuminance=20_000.0, **options)  # type: ignore[arg-type]
    without = make_sky(sun_illuminance=0.0, **options)  # type: ignore[arg-type]
    way = directions(256)
    above = way[..., 2] > 0.4
    sun = np.where(above[..., None], with_sun - without, 0.0).astype(float) @ WEIGHTS
    e, a = math.radians(50.0), math.radians(120.0)
    towards = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
    middle = (sun * solid_angles(256))[..., None] * way
    middle = middle.sum(axis=(0, 1)) / np.linalg.norm(middle.sum(axis=(0, 1)))
    assert middle @ towards == pytest.approx(1.0, abs=1e-5)
    lux = float((sun * np.clip(way @ towards, 0, None) * solid_angles(256)).sum())
    assert lux == pytest.approx(20_000.0, rel=0.01)


@pytest.mark.slow
def test_the_zenith_has_the_luminance_of_the_paper() -> None:
    """Preetham et al. 1999, A.2, worked by hand for turbidity 3 and the sun 60 degrees down."""
    sky = make_sky(height=512, turbidity=3.0, sun_elevation=30.0, sun_illuminance=0.0).astype(float)
    chi = (4 / 9 - 3 / 120) * (math.pi - 2 * math.radians(60))
    zenith = 1000 * ((4.0453 * 3 - 4.9710) * math.tan(chi) - 0.2155 * 3 + 2.4192)
    assert (sky[0] @ WEIGHTS).mean() == pytest.approx(zenith, rel=0.01)
    # Blue overhead, and bluer than the horizon away from the sun.
    assert sky[0, 0, 2] > sky[0, 0, 0]


def test_a_sky_is_radiance_everywhere_and_repeats() -> None:
    sky = make_sky(height=64, seed=3)
    assert sky.dtype == np.float32 and np.isfinite(sky).all() and sky.min() > 0
    np.testing.assert_array_equal(sky, make_sky(height=64, seed=3))
    assert (sky != make_sky(height=64, seed=4)).any()


def test_the_bundled_sky_is_the_one_that_is_made() -> None:
    with resources.as_file(resources.files("openrooms_usd.demo") / "sky.exr") as path:
        assert path.stat().st_size < 150_000
        bundled = read_panorama(str(path))
    made = make_sky()
    # Stored with eight significant bits.
    np.testing.assert_allclose(bundled, made, rtol=2.0**-8)
    assert 10_000 < horizontal_illuminance(bundled) < 100_000


def test_pictures_keep_every_bit(tmp_path: Path) -> None:
    pixels = np.random.default_rng(0).random((4, 8, 3), np.float32) * np.float32(1e30)
    write_exr(tmp_path / "a.exr", pixels)
    np.testing.assert_array_equal(read_texture(str(tmp_path / "a.exr")), pixels)
    first = (tmp_path / "a.exr").read_bytes()
    write_exr(tmp_path / "a.exr", pixels)
    assert (tmp_path / "a.exr").read_bytes() == first and b"20" not in first[:120]


@pytest.mark.parametrize(
    ("value", "words"),
    [(-1.0, "G = -1.0"), (math.nan, "G = nan"), (math.inf, "G = inf"), (-math.inf, "G = -inf")],
)
def test_pixels_that_are_no_radiance_are_refused(tmp_path: Path, value: float, words: str) -> None:
    pixels = np.ones((4, 8, 3), np.float32)
    pixels[2, 5, 1] = value
    write_exr(tmp_path / "a.exr", pixels)
    with pytest.raises(InputError, match=r"pixel \(5, 2\)") as caught:
        read_panorama(str(tmp_path / "a.exr"))
    assert words in str(caught.value) and "a.exr" in str(caught.value)


def test_other_shapes_are_refused(tmp_path: Path) -> None:
    write_exr(tmp_path / "a.exr", np.ones((4, 4, 3), np.float32))
    with pytest.raises(InputError, match="4 x 4 pixels"):
        read_panorama(str(tmp_path / "a.exr"))
    (tmp_path / "b.hdr").write_bytes(b"")
    with pytest.raises(InputError, match="picture"):
        read_panorama(str(tmp_path / "b.hdr"))
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 90000 +X 180000\n"
    (tmp_path / "c.hdr").write_bytes(header + b"\x00" * 64)
    with pytest.raises(InputError, match="picture"):
        read_panorama(str(tmp_path / "c.hdr"))


def test_grey_pictures_are_taken(tmp_path: Path) -> None:
    write_exr(tmp_path / "a.exr", np.full((4, 8), 2.0, np.float32))
    assert read_panorama(str(tmp_path / "a.exr")).tolist() == np.full((4, 8, 3), 2.0).tolist()


def test_the_odd_header_line_of_some_hdr_files_is_ignored(tmp_path: Path) -> None:
    header = (
        b"#?RADIANCE\nGAMMA=1\nPRIMARIES=0 0 0 0 0 0 0 0\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"
    )
    (tmp_path / "a.hdr").write_bytes(header + bytes([128, 64, 32, 129]) * 8)
    pixels = read_panorama(str(tmp_path / "a.hdr"))
    np.testing.assert_allclose(pixels[0, 0], [1.0, 0.5, 0.25], atol=0.01)


def test_scaling_to_lux(tmp_path: Path) -> None:
    pixels = np.random.default_rng(0).random((32, 64, 3), np.float32)
    scaled = scaled_to_nits(pixels, "a", illuminance=5000.0, scale=None)
    elevation = math.pi * (0.5 - (np.arange(32) + 0.5) / 32)
    luminance = scaled.astype(float) @ WEIGHTS
    cosines = np.clip(np.sin(elevation), 0, None)[:, None]
    assert (luminance * cosines * solid_angles(32)).sum() == pytest.approx(5000.0, rel=2e-3)
    np.testing.assert_allclose(scaled_to_nits(pixels, "a", illuminance=None, scale=3.0), pixels * 3)
    assert scaled_to_nits(pixels, "a", illuminance=None, scale=None).tolist() == pixels.tolist()


def test_a_sun_too_bright_for_a_float_is_refused() -> None:
    pixels = np.full((2, 4, 3), 1e36, np.float32)
    with pytest.raises(InputError, match="exceeds the range of floats"):
        scaled_to_nits(pixels, "a.exr", illuminance=None, scale=1e6)
    black = np.zeros((2, 4, 3), np.float32)
    with pytest.raises(InputError, match="upper half is black"):
        scaled_to_nits(black, "a.exr", illuminance=100.0, scale=None)


@pytest.mark.parametrize("name", ["apartment", "city", "park"])
def test_real_panoramas(name: str, real: Callable[[str], Path]) -> None:
    pixels = read_panorama(str(real(f"hdri/{name}.hdr")))
    assert pixels.shape == (512, 1024, 3)
    assert horizontal_illuminance(pixels) > 0


def test_write_errors_are_told(tmp_path: Path) -> None:
    from openrooms_usd.errors import OutputError

    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        write_exr(tmp_path / "file" / "a.exr", np.ones((2, 4, 3), np.float32))
    assert OpenImageIO.geterror() == ""
