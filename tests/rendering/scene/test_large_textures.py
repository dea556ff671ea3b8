"""Textures that are longer than is kept: means of what they stand for, told, and affordable."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering import render_stage
from openrooms_usd.rendering.scene import surfaces
from openrooms_usd.rendering.scene.codes import load_picture
from openrooms_usd.rendering.scene.pictures import Picture, load
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.shading.surfaces import Texture
from tests import small
from tests.pictures import save_picture
from tests.small import square


def speckled(path: Path, height: int, width: int, channels: int = 3) -> str:
    pixels = np.random.default_rng(5).integers(0, 256, (height, width, channels))
    write_png(path, pixels.astype(np.uint8))
    return str(path)


@pytest.mark.parametrize("space", ["sRGB", "raw"])
@pytest.mark.parametrize(("height", "width", "side"), [(64, 96, 32), (64, 96, 96), (50, 33, 8)])
def test_codes_are_those_of_the_means(
    tmp_path: Path, space: Any, height: int, width: int, side: int
) -> None:
    """Beside the means that floats give, by the other way to read a picture."""
    texture = Texture(speckled(tmp_path / "a.png", height, width), color_space=space)
    found = load_picture(texture, 3, (0.0, 1.0), np.eye(3), {}, side)
    assert found.coding is not None
    factor = 1
    while max(height, width) > side * factor:
        factor *= 2
    high, wide = height // factor, width // factor
    assert found.texels.shape == (high, wide, 3)
    whole = load_picture(texture, 3, (0.0, 1.0), np.eye(3), {}).pixels[::-1]
    cut = whole[: high * factor, : wide * factor].reshape(high, factor, wide, factor, 3)
    expected = cut.astype(np.float64).mean(axis=(1, 3))
    # Half a code, which is most of a step where sRGB is steep.
    steps = np.arange(256) / 255.0
    levels = linear_from_srgb(steps) if space == "sRGB" else steps
    assert np.abs(found.pixels[::-1] - expected).max() <= 0.5001 * np.diff(levels).max() + 1e-6
    assert bool(found.losses) == (factor > 1)


def test_alpha_is_never_decoded(tmp_path: Path) -> None:
    file = speckled(tmp_path / "a.png", 16, 16, 4)
    texture = Texture(file, channel="a", color_space="sRGB")
    small = load_picture(texture, 1, (0.0, 1.0), np.eye(3), {}, 1)
    whole = load_picture(texture, 1, (0.0, 1.0), np.eye(3), {})
    assert float(small.pixels[0, 0, 0]) == pytest.approx(float(whole.pixels.mean()), abs=0.003)


def test_pictures_of_floats_follow_too(tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).uniform(0.0, 4.0, (32, 32, 3)).astype(np.float32)
    file = save_picture(tmp_path / "a.exr", pixels)
    found = load(Texture(file), 3, (0.0, np.inf), np.eye(3), 8)
    expected = pixels.reshape(8, 4, 8, 4, 3).mean(axis=(1, 3))
    assert np.abs(found.pixels[::-1] - expected).max() < 2e-3


def board(path: Path, *, side: int = 64) -> Usd.Stage:
    made = small.Stage()
    color = Texture(speckled(path / "color.png", side, side), color_space="sRGB")
    rough = Texture(speckled(path / "rough.png", side, side), channel="r")
    material = made.material("/Look", base_color=color, roughness=rough)
    made.quad("/Board", square((0.5, 0.5, 0), 0.5), material=material)
    made.dome()
    return made.stage


def sides(scene: Any) -> set[int]:
    values = vars(scene.patches[0].surface).values()
    return {max(value.texels.shape[:2]) for value in values if isinstance(value, Picture)}


def test_a_stage_whose_textures_are_too_many_has_smaller_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage = board(tmp_path)
    assert sides(translate(stage)) == {64}
    # Three channels and one, three bytes each.
    whole = 64 * 64 * 4 * 3
    monkeypatch.setattr(surfaces, "_LEAST_SIDE", 1)
    monkeypatch.setattr(surfaces, "_MOST_TEXEL_BYTES", whole / 4.0)
    scene = translate(stage)
    assert sides(scene) == {32}
    told = " ".join(reason for _, _, reason in scene.report.rows)
    assert told.count("larger than 32 pixels, resized") == 2
    # Who says a side has it.
    assert sides(translate(stage, texture_side=16)) == {16}
    assert sides(translate(stage, texture_side=4096)) == {64}


def test_renders_have_it_and_refuse_what_is_none(tmp_path: Path) -> None:
    stage = board(tmp_path)
    stage.Export(str(tmp_path / "stage.usda"))
    asked = RenderSettings(renderer="preview", channels=["base_color"], resolution=(8, 6))
    summary = render_stage(tmp_path / "stage.usda", tmp_path / "out", asked.replace(texture_side=8))
    assert any("larger than 8 pixels" in reason for _, _, reason in summary.report.rows)
    with pytest.raises(InputError, match="texture side"):
        render_stage(tmp_path / "stage.usda", tmp_path / "no", asked.replace(texture_side=0))
