"""RGBE pictures: read back by OpenImageIO, which shares no code with the writer."""

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError
from orusd_openrooms.images import ERROR, encode, write_rgbe
from orusd_openrooms.readers import read_light


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
