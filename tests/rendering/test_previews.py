"""Pictures for people."""

import numpy as np
import pytest

from openrooms_usd.channels import CHANNELS
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.errors import OutputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering import color
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.sheet import tiles, write_sheet


@pytest.mark.parametrize("name", CHANNELS)
def test_every_channel_has_a_picture(name, numbers):
    shown = preview(name, numbers(name, 32, 64, 0))
    assert shown.pixels.dtype == np.uint8
    assert shown.pixels.shape[:2] == (32, 64)
    assert shown.shows


@pytest.mark.parametrize("name", CHANNELS)
def test_nothing_but_zeros_and_what_is_not_finite(name):
    pixels = np.zeros((32, 64, len(CHANNELS[name].components)), np.float32)
    pixels[0, 0] = np.nan
    pixels[1, 2, -1] = np.inf
    shown = preview(name, pixels).pixels
    magenta = (shown == color.NONFINITE).all(axis=-1)
    assert np.argwhere(magenta).tolist() == [[0, 0], [1, 2]]
    assert shown[3, 3].max() == 0


def test_near_is_bright_and_nowhere_is_black():
    depth = np.linspace(1, 6, 100, dtype=np.float32).reshape(1, 100, 1)
    depth[0, 50] = 0
    shown = preview("depth", depth).pixels.astype(int).sum(axis=-1)[0]
    assert shown[50] == 0
    assert np.all(np.diff(np.delete(shown, 50)) <= 0)


def test_normals_are_coded_as_everybody_does():
    normals = np.array([[[1, 0, 0], [0, 1, 0], [0, 0, -1], [0, 0, 0]]], np.float32)
    shown = preview("normal", normals).pixels[0]
    assert shown.tolist() == [[255, 128, 128], [128, 255, 128], [128, 128, 0], [0, 0, 0]]


def test_exposure_of_the_camera_counts():
    radiance = np.full((4, 4, 3), 180.0, np.float32)
    for exposure in (0.0005, 0.001, 0.004):
        shown = preview("radiance", radiance, exposure=exposure, tone="film")
        grey = color.film(np.full(3, 180 * exposure))
        expected = color.quantize(srgb_from_linear(grey)).astype(int)
        assert np.abs(shown.pixels.astype(int) - expected).max() <= 1
        assert f"{exposure:.3g}" in shown.shows
    fitted = preview("radiance", radiance).pixels
    assert np.array_equal(fitted, preview("radiance", 9 * radiance).pixels)


def test_png_keeps_every_byte(tmp_path):
    import OpenImageIO

    pixels = np.random.default_rng(0).integers(0, 256, (9, 7, 3)).astype(np.uint8)
    for name in ("a.png", "b.png"):
        write_png(tmp_path / name, pixels)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    back = OpenImageIO.ImageBuf(str(tmp_path / "a.png")).get_pixels(OpenImageIO.UINT8)
    assert np.array_equal(back, pixels)


@pytest.mark.parametrize("size", [1, 20, 400])
def test_full_disk_is_an_error(tmp_path, size):
    full = tmp_path / "a.png"
    full.symlink_to("/dev/full")
    pixels = np.random.default_rng(0).integers(0, 256, (size, size, 3)).astype(np.uint8)
    with pytest.raises(OutputError, match="cannot write"):
        write_png(full, pixels)


def test_sheet_shows_every_view_and_channel(tmp_path, numbers):
    import OpenImageIO

    names = ("radiance", "depth", "instance", "valid")
    shown = {name: preview(name, numbers(name, 30, 40, 0)) for name in names}
    row = tiles("left", shown)
    assert [caption.split()[:2] for caption, _ in row] == [
        ["left", "radiance"],
        ["left", "depth"],
        ["left", "instance"],
    ]
    write_sheet(tmp_path / "sheet.png", [row, row[:1]])
    sheet = OpenImageIO.ImageBuf(str(tmp_path / "sheet.png")).get_pixels(OpenImageIO.UINT8)
    for _, picture in row:
        tall, wide = picture.shape[:2]
        hits = [
            (y, x)
            for y, x in np.argwhere((sheet == picture[0, 0]).all(axis=-1))
            if np.array_equal(sheet[y : y + tall, x : x + wide], picture)
        ]
        assert hits, "a tile is not on the sheet, or a caption runs over it"
    assert (tmp_path / "sheet.png").stat().st_size > 0
