"""What surfaces become of UsdPreviewSurface: numbers in closed form, and what is told."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering.scene.pictures import Picture
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
    assert any("clearcoat is taken as its mean" in loss for loss in made.losses)
    made = read(specular=Texture(half))
    assert f0_of(made.ior) == pytest.approx(0.4, abs=1e-3)
    assert any("taken as its mean" in loss for loss in made.losses)


def test_a_grey_specular_colour_is_an_index_of_refraction() -> None:
    made = read(specular=(0.25, 0.25, 0.25))
    # (n - 1) / (n + 1) = 1 / 2.
    assert made.ior == pytest.approx(3.0) and made.losses == ()
    assert any("colourless" in loss for loss in read(specular=(0.1, 0.2, 0.3)).losses)
    assert read(specular=(0.0, 0.0, 0.0)).ior == 1.0


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
