"""Textures that break renderers: one texel, many bits, floats, no numbers, no hue, no file."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering.scene.pictures import Picture, load, mended
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, Texture
from tests import small
from tests.pictures import save_picture
from tests.small import square

QUAD = square((0, 0, 0), 1)
UNIT, NORMAL, ANY = (0.0, 1.0), (-1.0, 1.0), (0.0, math.inf)
Save = Callable[..., str]


@pytest.fixture
def save(tmp_path: Path) -> Save:
    """Write (H, W, C) values of 0..1, or floats as they are, in a type of pixels."""

    return lambda name, values, kind: save_picture(
        tmp_path / name, np.asarray(values, dtype=np.float32), kind
    )


def loaded(texture: Texture, channels: int = 3, limits: tuple[float, float] = UNIT) -> Picture:
    return load(texture, channels, limits, np.eye(3))


def decoded(encoded: Any) -> Any:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (5, 1)])
def test_one_texel_is_a_constant_for_channel_and_renderer(
    shoot: Any, save: Save, shape: tuple[int, int]
) -> None:
    color = np.array([0.8, 0.4, 0.2])
    file = save("one.png", np.broadcast_to(color, (*shape, 3)), "uint8")
    made = small.Stage()
    material = made.material("/Paper", base_color=Texture(file))
    made.quad("/Quad", QUAD, material=material)
    made.camera((0, 0, 3), (0, 0, 0), up=(0, 1, 0), fov=20)
    made.dome(radiance=1.0)
    images = shoot(made.stage, "base_color", "radiance", samples=16, bounces=1).images
    assert np.abs(images["base_color"].pixels - color).max() < 2e-3
    assert np.abs(images["radiance"].pixels.mean(axis=(0, 1)) - color).max() < 2e-3


@pytest.mark.parametrize(("suffix", "kind"), [("png", "uint16"), ("tif", "uint16")])
def test_sixteen_bits_are_finer_than_eight(save: Save, suffix: str, kind: str) -> None:
    values = np.linspace(0.5, 0.502, 9).reshape(3, 3, 1).repeat(3, axis=2)
    file = save(f"deep.{suffix}", values, kind)
    plain = loaded(Texture(file)).pixels[::-1].astype(np.float64)
    # Half precision keeps 11 bits: between 0.5 and 1 its steps are 1/2048.
    assert np.abs(plain - values).max() <= 0.5 / 2048 + 1e-5
    assert len(np.unique(plain)) > len(np.unique(np.round(values * 255)))
    encoded = loaded(Texture(file, color_space="sRGB")).pixels[::-1].astype(np.float64)
    assert np.abs(encoded - decoded(values)).max() < 3e-4


@pytest.mark.parametrize("name", ["f.exr", "f.tif"])
@pytest.mark.parametrize("kind", ["half", "float"])
def test_floats_keep_their_range_within_what_makes_sense(save: Save, name: str, kind: str) -> None:
    if name.endswith("tif") and kind == "half":
        kind = "float"
    values = np.array([[[0.0, 0.5, 1.0], [-3.0, 2.0, 1e5 if kind == "float" else 1e4]]])
    file = save(name, values, kind)
    assert np.allclose(loaded(Texture(file)).pixels, np.clip(values, 0, 1))
    wide = loaded(Texture(file), limits=ANY).pixels
    assert np.allclose(wide, np.clip(values, 0, None), rtol=1e-3)


def test_texels_that_are_no_numbers_become_the_mean_of_their_neighbours(save: Save) -> None:
    values = np.random.default_rng(4).random((6, 6, 3)).astype(np.float32)
    holes = {(0, 0): np.nan, (3, 3): np.inf, (5, 2): -np.inf}
    damaged = values.copy()
    for texel, value in holes.items():
        damaged[texel] = value
    picture = loaded(Texture(save("nan.exr", damaged, "float")))
    found = picture.pixels[::-1].astype(np.float64)
    for row, column in holes:
        around = [
            values[(row + i) % 6, (column + j) % 6]
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
            if (i, j) != (0, 0)
        ]
        assert np.allclose(found[row, column], np.mean(around, axis=0), atol=1e-3)
    kept = np.ones((6, 6), bool)
    kept[tuple(zip(*holes, strict=True))] = False
    assert np.allclose(found[kept], values[kept], atol=1e-3)
    assert any("3 texels are not numbers" in loss for loss in picture.losses)


def test_large_holes_become_the_mean_and_empty_pictures_zero() -> None:
    hole = np.full((9, 9, 1), np.nan, dtype=np.float32)
    hole[:, 0] = np.arange(9).reshape(9, 1)
    filled, count = mended(hole)
    assert count == 72
    assert filled[4, 4] == pytest.approx(4.0)
    empty, count = mended(np.full((2, 2, 3), np.nan, dtype=np.float32))
    assert (empty == 0).all()
    assert count == 4
    whole = np.ones((2, 2, 3), dtype=np.float32)
    assert mended(whole)[0] is whole


def test_no_numbers_do_not_spread_when_a_picture_is_made_smaller(save: Save) -> None:
    values = np.zeros((2, 4098, 1), dtype=np.float32)
    # The hole lies in one block with three ones: they must count, as they do without the hole.
    values[:, 6:8] = 1.0
    values[0, 7] = np.nan
    picture = loaded(Texture(save("long.exr", values, "float")), channels=1)
    assert picture.pixels.shape[1] == 2049
    assert 0.75 < picture.pixels[0, 3, 0] <= 1.0
    assert np.count_nonzero(picture.pixels) == 1


@pytest.mark.parametrize("channels", [1, 2, 3])
def test_a_grey_scale_normal_map_is_left_out(save: Save, channels: int) -> None:
    grey = np.random.default_rng(1).random((4, 4, 1)).repeat(channels, axis=2)
    texture = Texture(save("grey.png", grey, "uint8"), scale=NORMAL_SCALE, bias=NORMAL_BIAS)
    picture = loaded(texture, limits=NORMAL)
    assert np.array_equal(picture.pixels.reshape(-1, 3), [[0, 0, 1]])
    assert any("cannot be a normal map" in loss for loss in picture.losses)


def test_normals_without_length_point_outwards(save: Save) -> None:
    values = np.array([[[0.5, 0.5, 0.5], [0.5, 0.5, 1.0], [1.0, 0.5, 0.5]]])
    texture = Texture(save("n.exr", values, "float"), scale=NORMAL_SCALE, bias=NORMAL_BIAS)
    picture = loaded(texture, limits=NORMAL)
    assert np.allclose(picture.pixels, [[[0, 0, 1], [0, 0, 1], [1, 0, 0]]])
    assert any("of length zero" in loss for loss in picture.losses)


def test_grey_with_alpha_and_palettes_are_colours(save: Save, tmp_path: Path) -> None:
    grey = np.dstack([np.full((2, 2), 0.6), np.full((2, 2), 0.25)])
    file = save("la.png", grey, "uint8")
    assert np.allclose(loaded(Texture(file)).pixels, 0.6, atol=1e-3)
    assert np.allclose(loaded(Texture(file, channel="a"), 1).pixels, 0.25, atol=3e-3)
    palette = tmp_path / "palette.png"
    palette.write_bytes(two_colour_png())
    pixels = loaded(Texture(str(palette))).pixels[::-1]
    assert np.allclose(pixels, [[[1, 0, 0], [0, 0, 1]]], atol=1e-3)


def two_colour_png() -> bytes:
    """A palette PNG of two pixels, red and blue, one bit each, by the format's specification."""
    import struct
    import zlib

    def chunk(kind: bytes, data: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + check

    header = struct.pack(">IIBBBBB", 2, 1, 1, 3, 0, 0, 0)
    colours, rows = bytes([255, 0, 0, 0, 0, 255]), zlib.compress(bytes([0, 0b01000000]))
    parts = (chunk(b"IHDR", header), chunk(b"PLTE", colours), chunk(b"IDAT", rows))
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts) + chunk(b"IEND", b"")


@pytest.mark.parametrize("limits", [UNIT, NORMAL])
def test_a_missing_file_shows_its_fallback_and_says_so(tmp_path: Path, limits: Any) -> None:
    texture = Texture(str(tmp_path / "gone.png"), fallback=(0.25, 0.5, 1.0, 1.0))
    picture = loaded(texture, limits=limits)
    assert np.allclose(picture.pixels, (0.25, 0.5, 1.0))
    assert any("gone.png cannot be read: no such file" in loss for loss in picture.losses)
