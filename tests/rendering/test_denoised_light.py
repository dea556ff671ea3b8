"""Denoised versions of channels of light: which there are, and what their means are off by."""

import numpy as np
import pytest

from openrooms_usd.channels import CHANNELS
from openrooms_usd.rendering import Image, View
from openrooms_usd.rendering.channel_plan import (
    RATIOS,
    RECEIVED,
    REFLECTED,
    energy_change,
    with_denoised_light,
)
from openrooms_usd.rendering.denoise import Denoiser, load_denoiser
from openrooms_usd.rendering.estimates import Halves
from openrooms_usd.rendering.halves import KeptHalves

SIZE = (32, 48)


@pytest.fixture(scope="module")
def denoiser() -> Denoiser:
    return load_denoiser()


def picture(level: float, spread: float, seed: int) -> Image:
    """An even picture of a level, whose two halves are noisy, all colours alike."""
    random = np.random.default_rng(seed)
    few = 1.0 / max(spread, 1e-6) ** 2
    a, b = (
        np.repeat(level * random.gamma(few, 1.0 / few, (*SIZE, 1)), 3, axis=2) for _ in range(2)
    )
    pixels = ((a + b) / 2).astype(np.float32)
    return Image(pixels, 8, 0.0, None, halves=KeptHalves.made(pixels, Halves(a, b, (4, 4))))


def view(**images: Image) -> View:
    normal, color = np.zeros((*SIZE, 3), np.float32), np.full((*SIZE, 3), 0.5, np.float32)
    normal[..., 2] = 1.0
    # A texture that nothing that is received may show.
    color[:, ::2] = 0.1
    guides = {"normal": normal, "base_color": color}
    return View(None, SIZE[1], SIZE[0], np.eye(3), np.eye(4), None, images, guides=guides)


def test_every_channel_that_can_bear_it_is_denoised_and_raw_ones_stay(denoiser: Denoiser) -> None:
    signed = picture(1.0, 0.1, 1)
    signed.pixels[0, 0] = -1.0
    raw = {
        "direct": picture(30.0, 0.8, 2),
        "irradiance_3": picture(200.0, 0.8, 3),
        "visibility_0": picture(0.3, 0.3, 4),
        "mask_0": picture(1.0, 0.0, 5),
        "residual": signed,
        "specular": signed,
        "environment": picture(5.0, 0.1, 6),
    }
    seen = view(**raw)
    found = with_denoised_light(seen, denoiser)
    assert set(found.denoised) == {"direct", "irradiance_3", "visibility_0"}
    assert set(found.denoised_of("light")) == {"irradiance_3", "visibility_0"}
    assert found.images == seen.images
    for name, image in found.denoised.items():
        # What is reflected may show the texture.
        left = 0.8 if name == "direct" else 0.4
        assert image.pixels.std() < left * raw[name].pixels.std()
        assert image.change["bias"] == pytest.approx(
            image.pixels.mean() / raw[name].pixels.mean() - 1, abs=1e-6
        )
    even = found.denoised["irradiance_3"].pixels.mean(axis=(0, 2))
    assert np.abs(even[::2].mean() / even[1::2].mean() - 1) < 0.02


def test_the_table_names_channels_of_light_that_are_never_negative() -> None:
    for name in (*REFLECTED, *RECEIVED, *RATIOS):
        assert CHANNELS[name].scope in {"view", "light"} and CHANNELS[name].components == (*"RGB",)


def test_a_bias_stands_out_of_the_noise_and_noise_does_not() -> None:
    raw = picture(10.0, 0.3, 7)
    same = energy_change(raw.pixels, np.full_like(raw.pixels, 10.0), raw.halves)
    assert same.bias is not None and same.standard_error is not None
    assert abs(same.bias) < 3.5 * same.standard_error
    assert same.blocks_beyond is not None and same.blocks_beyond <= 0.34
    made = 0.3 / np.sqrt(2) / np.sqrt(raw.pixels[..., 0].size)
    assert same.standard_error == pytest.approx(made, rel=0.1)
    darker = energy_change(raw.pixels, np.full_like(raw.pixels, 8.0), raw.halves)
    assert darker.bias == pytest.approx(-0.2, abs=0.03)
    assert darker.blocks_beyond == 1.0
    assert energy_change(0 * raw.pixels, 0 * raw.pixels, None).bias is None
