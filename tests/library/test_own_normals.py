"""Normal maps that do not say their convention are measured; what is none is left out."""

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from numpy.typing import NDArray

from openrooms_usd.library.ownmaterials.normalmaps import Relief, green_agreement, read_relief

SIDE = 64
Array = NDArray[np.float64]


def write(path: Path, pixels: Array, kind: str) -> str:
    height, width, channels = pixels.shape
    file = OpenImageIO.ImageOutput.create(str(path))
    assert file.open(str(path), OpenImageIO.ImageSpec(width, height, channels, kind))
    assert file.write_image(np.ascontiguousarray(pixels, dtype=np.float32))
    file.close()
    return str(path)


def relief(seed: int, *, grooves: bool = False) -> tuple[Array, Array]:
    """Heights of a sum of waves with their OpenGL normals by its exact derivatives."""
    rng = np.random.default_rng(seed)
    s, t = np.meshgrid((np.arange(SIDE) + 0.5) / SIDE, 1 - (np.arange(SIDE) + 0.5) / SIDE)
    height, along_s, along_t = np.zeros_like(s), np.zeros_like(s), np.zeros_like(s)
    for _ in range(6):
        m, n = (0, rng.integers(1, 4)) if grooves else rng.integers(-3, 4, 2)
        phase, size = rng.uniform(0, 2 * np.pi), 0.02
        angle = 2 * np.pi * (m * s + n * t) + phase
        height += size * np.sin(angle)
        along_s += size * 2 * np.pi * m * np.cos(angle)
        along_t += size * 2 * np.pi * n * np.cos(angle)
    normals = np.dstack([-along_s, -along_t, np.ones_like(s)])
    return height, normals / np.linalg.norm(normals, axis=2, keepdims=True)


def packed(normals: Array) -> Array:
    return np.asarray((normals + 1) / 2)


@pytest.mark.parametrize("seed", range(5))
def test_slopes_tell_where_green_points(seed: int) -> None:
    _, normals = relief(seed)
    assert green_agreement(normals) > 0.9
    assert green_agreement(normals * (1, -1, 1)) < -0.9


@pytest.mark.parametrize("sign", [1, -1])
def test_grooves_along_one_axis_are_told_by_their_heights(tmp_path: Path, sign: int) -> None:
    height, normals = relief(3, grooves=True)
    file = write(tmp_path / "n.png", packed(normals * (1, sign, 1)), "uint8")
    heights = write(tmp_path / "h.png", (height - height.min())[..., None] * 4, "uint8")
    blind = read_relief(file, None)
    assert isinstance(blind, Relief)
    assert "OpenGL is assumed" in blind.losses[0]
    seen = read_relief(file, None, heights)
    assert isinstance(seen, Relief)
    assert np.sign(seen.scale[1]) == sign
    assert "by its displacement map" in seen.losses[0]


@pytest.mark.parametrize("stated", ["up", "down", None])
@pytest.mark.parametrize(("suffix", "signed"), [(".png", False), (".exr", False), (".exr", True)])
def test_the_way_from_stored_values_to_opengl(
    tmp_path: Path, stated: str | None, suffix: str, signed: bool
) -> None:
    _, normals = relief(1)
    written = normals * (1, 1 if stated == "up" else -1, 1)
    values = written if signed else packed(written)
    kind = "float" if suffix == ".exr" else "uint16"
    found = read_relief(write(tmp_path / f"n{suffix}", values, kind), stated)  # type: ignore[arg-type]
    assert isinstance(found, Relief)
    restored = values * found.scale[:3] + found.bias[:3]
    assert np.abs(restored - normals).max() < 1e-6
    assert bool(found.losses) == (stated is None)


@pytest.mark.parametrize("channels", [1, 3])
def test_grey_pictures_are_no_normal_maps(tmp_path: Path, channels: int) -> None:
    height, _ = relief(2)
    grey = np.repeat((height - height.min())[..., None], channels, axis=2)
    reason = read_relief(write(tmp_path / "n.png", grey, "uint8"), "up")
    assert isinstance(reason, str)
    assert "heights, not normals" in reason


def test_a_single_texel_is_a_normal(tmp_path: Path) -> None:
    found = read_relief(write(tmp_path / "n.png", np.array([[[0.5, 0.5, 1.0]]]), "uint8"), None)
    assert isinstance(found, Relief)
