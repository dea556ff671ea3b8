"""Pictures of light: RGBE and hemispheres, their tiling, channels, integral and grids."""

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.rendering.datasets import DatasetOptions
from openrooms_usd.rendering.reading import RenderedScene
from orusd_openrooms import OpenRoomsDataset, frame
from orusd_openrooms.frame import area_mean
from orusd_openrooms.images import ERROR, encode, write_rgbe
from orusd_openrooms.readers import read_environments, read_light
from tests.openrooms.synthetic import make_render


def decoded(code: np.ndarray) -> np.ndarray:
    """The format's own definition: mantissa 2^(exponent - 136)."""
    return code[..., :3] * np.exp2(code[..., 3:].astype(np.float64) - 136) * (code[..., 3:] > 0)


@pytest.fixture(scope="module")
def light() -> np.ndarray:
    rng = np.random.default_rng(1)
    return np.exp(rng.normal(0.0, 5.0, (40, 100, 3))).astype(np.float32)


@pytest.mark.parametrize("suffix", [".hdr", ".rgbe"])
@pytest.mark.parametrize("width", [1, 7, 8, 100])
def test_the_error_is_half_a_step(
    light: np.ndarray, width: int, suffix: str, tmp_path: Path
) -> None:
    path = tmp_path / f"im{suffix}"
    write_rgbe(path, light[:, :width])
    found = read_light(path)
    assert found.shape == (40, width, 3)
    largest = light[:, :width].max(axis=-1, keepdims=True)
    assert (np.abs(found - light[:, :width]) <= (ERROR + 1e-6) * largest).all()


def test_the_reader_and_the_definition_agree(light: np.ndarray, tmp_path: Path) -> None:
    write_rgbe(tmp_path / "im.hdr", light)
    np.testing.assert_array_equal(read_light(tmp_path / "im.hdr"), decoded(encode(light)))


def test_rounding_leaves_no_bias() -> None:
    values = np.exp2(np.random.default_rng(2).random((200_000, 3)) * 8).astype(np.float32)
    relative = decoded(encode(values)).sum() / values.astype(np.float64).sum() - 1.0
    assert abs(relative) < 2e-4  # cutting off loses about 2e-3


def test_what_the_format_holds_stays_as_it_is() -> None:
    rng = np.random.default_rng(3)
    code = rng.integers(0, 256, (1000, 4))
    code[:, 0] = rng.integers(128, 256, 1000)  # of many codes of a value the one with a full lead
    code[:, 3] = rng.integers(20, 250, 1000)
    np.testing.assert_array_equal(encode(decoded(code).astype(np.float32)), code)


@pytest.mark.parametrize(
    ("pixel", "code"),
    [
        ([0, 0, 0], [0, 0, 0, 0]),
        ([1, 0.5, 0.25], [128, 64, 32, 129]),
        ([255.9, 0, 0], [128, 0, 0, 137]),  # 255.9 rounds to 256, which needs the next exponent
        ([-1, 2, np.nan], [0, 128, 0, 130]),
        ([1e-39, 0, 0], [0, 0, 0, 0]),
    ],
)
def test_single_pixels(pixel: list[float], code: list[int]) -> None:
    assert encode(np.array([pixel], np.float32)).tolist() == [code]


def test_infinity_is_the_largest_value(tmp_path: Path) -> None:
    write_rgbe(tmp_path / "im.hdr", np.full((2, 2, 3), np.inf, np.float32))
    assert np.isfinite(read_light(tmp_path / "im.hdr")).all()


def test_a_picture_of_another_writer_is_read(light: np.ndarray, tmp_path: Path) -> None:
    path = tmp_path / "other.hdr"
    spec = OpenImageIO.ImageSpec(100, 40, 3, OpenImageIO.FLOAT)
    output = OpenImageIO.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(light) and output.close()
    largest = light.max(axis=-1, keepdims=True)
    assert (np.abs(read_light(path) - light) <= 2.1 * ERROR * largest).all()


def test_equal_pixels_give_equal_bytes(light: np.ndarray, tmp_path: Path) -> None:
    for name in ("a.hdr", "b.hdr"):
        write_rgbe(tmp_path / name, light)
    assert (tmp_path / "a.hdr").read_bytes() == (tmp_path / "b.hdr").read_bytes()


def test_a_text_is_no_picture(tmp_path: Path) -> None:
    (tmp_path / "im.hdr").write_text("#?RADIANCE\n", encoding="utf-8")
    with pytest.raises(InputError, match="image"):
        read_light(tmp_path / "im.hdr")


IMENV = "SVLighting/main_xml/scene0000_00/imenv_1.hdr"


@pytest.mark.parametrize("order", ["legacy", "rgb"])
def test_both_orders_read_back(order: str, render: RenderedScene, tmp_path: Path) -> None:
    OpenRoomsDataset().write([render], tmp_path, DatasetOptions(order=order))
    expected = render.views["view_0"].grid("environment")
    found = read_environments(tmp_path / IMENV, order)
    assert expected is not None and found.shape == (12, 16, 16, 32, 3)
    bound = (ERROR + 1e-6) * expected.max(axis=-1, keepdims=True)
    assert (np.abs(found - expected) <= bound).all()
    other = read_environments(tmp_path / IMENV, "rgb" if order == "legacy" else "legacy")
    np.testing.assert_array_equal(other, found[..., ::-1])


def test_legacy_stores_red_where_the_format_has_blue(render: RenderedScene, tmp_path: Path) -> None:
    OpenRoomsDataset().write([render], tmp_path, DatasetOptions())
    grid = render.views["view_0"].grid("environment")
    assert grid is not None
    stored = read_light(tmp_path / IMENV)
    # Row 3 and column 5 of the grid, elevation 2 and azimuth 30.
    np.testing.assert_allclose(stored[3 * 16 + 2, 5 * 32 + 30], grid[3, 5, 2, 30][::-1], atol=2.0)


def test_even_light_gives_pi_times_it() -> None:
    even = np.full((2, 3, 16, 32, 3), [1.0, 2.0, 3.0], np.float32)
    np.testing.assert_allclose(
        frame.irradiance(even), np.broadcast_to([np.pi, 2 * np.pi, 3 * np.pi], (2, 3, 3)), rtol=1e-6
    )


def test_a_cosine_of_light_gives_two_thirds_of_pi() -> None:
    edges = np.cos(np.linspace(0, np.pi / 2, 17))
    means = 0.5 * (edges[:-1] + edges[1:])  # of the cosine over the solid angle of a belt
    grid = np.broadcast_to(means[:, None, None], (1, 1, 16, 32, 3)).astype(np.float32)
    # Light that is not even inside a cell: the discretisation's share.
    np.testing.assert_allclose(frame.irradiance(grid), 2 * np.pi / 3, rtol=2e-3)


def test_a_coarser_grid_holds_means_over_blocks(render: RenderedScene) -> None:
    grid = render.views["view_0"].grid("environment_direct")
    assert grid is not None
    coarse = frame.coarser(grid, 4)
    assert coarse.shape == (3, 4, 16, 32, 3)
    np.testing.assert_allclose(coarse[1, 2], grid[4:8, 8:12].mean(axis=(0, 1)), rtol=1e-5)


@pytest.mark.parametrize("size", [(4, 6), (3, 5), (12, 16), (5, 9), (24, 20)])
def test_a_mean_by_area_keeps_the_mean(size: tuple[int, int]) -> None:
    pixels = np.random.default_rng(0).random((12, 16, 2)).astype(np.float32)
    found = area_mean(pixels, *size)
    assert found.shape == (*size, 2)
    np.testing.assert_allclose(found.mean(axis=(0, 1)), pixels.mean(axis=(0, 1)), rtol=1e-6)


def test_a_mean_by_area_is_the_mean_of_a_block() -> None:
    pixels = np.random.default_rng(0).random((12, 16, 3)).astype(np.float32)
    blocks = pixels.reshape(3, 4, 4, 4, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(area_mean(pixels, 3, 4), blocks, rtol=1e-6)
    np.testing.assert_allclose(area_mean(pixels, 12, 16), pixels, rtol=1e-6)


def test_a_ramp_stays_a_ramp_at_odd_sizes() -> None:
    ramp = (np.arange(10) + 0.5)[None, :, None] * np.ones((1, 10, 1))
    found = area_mean(ramp, 1, 4)[0, :, 0]
    np.testing.assert_allclose(found, [1.3, 3.7, 6.3, 8.7])


def test_a_picture_of_another_size_is_no_grid(tmp_path: Path) -> None:
    write_rgbe(tmp_path / "imenv_1.hdr", np.ones((16, 40, 3), np.float32))
    with pytest.raises(InputError, match="not a grid of 32x16"):
        read_environments(tmp_path / "imenv_1.hdr")


@pytest.mark.slow
def test_the_sizes_of_the_release(tmp_path: Path) -> None:
    """640x480, hemispheres on 160x120 points; what is direct on 40x30."""
    render = make_render(tmp_path / "full", (640, 480), (120, 160), views=1)
    summary = OpenRoomsDataset().write([render], tmp_path / "data", DatasetOptions())
    assert summary.missing == {}
    [caution] = summary.notes
    assert "layout merged" in caution
    sizes = {
        "Image/main_xml/scene0000_00/im_1.hdr": (480, 640, 3),
        IMENV: (1920, 5120, 3),
        "SVLightingDirect/main_xml/scene0000_00/imenvDirect_1.hdr": (480, 1280, 3),
        "Shading/main_xml/scene0000_00/imshading_1.hdr": (120, 160, 3),
        "ShadingDirect/main_xml/scene0000_00/imshadingDirect_1.rgbe": (120, 160, 3),
        "LightSource/main_xml/scene0000_00/light_1/imDS0.rgbe": (120, 160, 3),
    }
    for name, shape in sizes.items():
        assert read_light(tmp_path / "data" / name).shape == shape, name
