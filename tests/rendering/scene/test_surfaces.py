"""What surfaces become of UsdPreviewSurface: numbers in closed form, and what is told."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering.scene.pictures import Picture, evaluate
from openrooms_usd.rendering.scene.surfaces import Surface, SurfaceReader
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture, f0_of
from tests.pictures import save_picture


def read(**inputs: Any) -> Surface:
    return SurfaceReader().read(PreviewSurface(**inputs))


@pytest.fixture
def half(tmp_path: Path) -> str:
    """A picture whose mean is (0.2, 0.4, 0.6)."""
    pixels = np.array([[[0, 0, 51], [102, 204, 255]]], np.uint8)
    return save_picture(tmp_path / "half.png", pixels)


def test_a_constant_normal_is_a_map_of_one_texel() -> None:
    made = read(normal=(0.0, 1.2, 1.6))
    assert isinstance(made.normal, Picture) and made.losses == ()
    seen = made.normal.lookup(np.array([[0.3, 0.7], [5.0, -2.0]]))
    assert seen == pytest.approx(np.array([[0.0, 0.6, 0.8]] * 2), abs=1e-6)
    assert read(normal=(0.0, 0.0, 1.0)).normal is None
    assert read(normal=(0.0, 0.0, 0.0)).normal is None


def test_what_is_textured_and_cannot_be_is_its_mean(half: str) -> None:
    coat = Texture(half, channel="g")
    made = read(clearcoat=coat, clearcoat_roughness=Texture(half, channel="r"))
    assert made.clearcoat == pytest.approx(0.4, abs=1e-3)
    assert made.clearcoat_roughness == pytest.approx(0.2, abs=1e-3)
    assert any("clearcoat is replaced by its mean" in loss for loss in made.losses)


def test_a_specular_colour_keeps_its_hue(half: str) -> None:
    made = read(specular=(0.9, 0.3, 0.1), metallic=0.7)
    assert made.specular == (0.9, 0.3, 0.1) and (made.metallic, made.losses) == (0.0, ())
    textured = read(specular=Texture(half)).specular
    assert isinstance(textured, Picture)
    assert textured.lookup(np.array([0.25, 0.5])) == pytest.approx((0.0, 0.0, 0.2), abs=1e-6)
    # What stands for it elsewhere: (n - 1) / (n + 1) = 1 / 2.
    assert read(specular=(0.25, 0.25, 0.25)).dielectric == pytest.approx(3.0)
    assert f0_of(read(specular=Texture(half)).dielectric) == pytest.approx(0.4, abs=1e-3)


def test_opacity_and_its_modes() -> None:
    assert read(opacity=0.4, opacity_threshold=0.4).opacity == 1.0
    assert read(opacity=0.4, opacity_threshold=0.5).opacity == 0.0
    assert read(opacity=0.4, opacity_mode="presence").losses == ()
    assert any("reflect nothing" in loss for loss in read(opacity=0.4).losses)
    # The mode means nothing of a mask.
    assert read(opacity=0.4, opacity_threshold=0.5).losses == ()


def test_a_coat_is_as_wide_as_its_roughness_says() -> None:
    from orusd_mitsuba.plugins.descriptions import describe_bsdf

    for roughness in (0.1, 0.2, 0.3):
        lobes = str(describe_bsdf(read(clearcoat=1.0, clearcoat_roughness=roughness)))
        gloss = float(lobes.split("'clearcoat_gloss': ")[1].split("}")[0].split(",")[0])
        # Disney's alpha is 0.1 without gloss and 0.001 with all of it.
        assert 0.1 + (0.001 - 0.1) * gloss == pytest.approx(roughness**2)


def test_what_is_not_there_emits_nothing(tmp_path: Path) -> None:
    """By its threshold or in part; clear glass may glow (opacityMode transparent)."""
    there = save_picture(tmp_path / "mask.png", np.array([[[51] * 3, [255] * 3]], np.uint8))
    glow = save_picture(tmp_path / "glow.png", np.array([[[102] * 3], [[204] * 3]], np.uint8))
    opacity, emissive = Texture(there, channel="r"), Texture(glow, scale=(10.0,) * 4)
    left, right = np.array([[[0.25, 0.75]], [[0.75, 0.75]]])

    def seen(**inputs: Any) -> list[float]:
        found = read(**({"emissive": (5.0, 5.0, 5.0), "opacity": opacity} | inputs)).emission
        return [float(evaluate(found or 0.0, at, 3)[0, 0]) for at in (left, right)]

    assert seen() == [5.0, 5.0]
    assert seen(opacity_threshold=0.5) == [0.0, 5.0]
    assert seen(opacity_mode="presence") == pytest.approx([1.0, 5.0], rel=1e-3)
    assert seen(opacity_mode="presence", opacity=0.5) == [2.5, 2.5]
    assert seen(opacity_threshold=0.6, opacity=0.5) == [0.0, 0.0]
    assert seen(opacity_threshold=0.5, emissive=emissive) == pytest.approx([0.0, 4.0], rel=1e-3)
    assert seen(opacity_mode="presence", emissive=emissive) == pytest.approx([0.8, 4.0], rel=1e-3)
