"""Likeness of renders and photographs: exposure and white balance do not count, all else does."""

import numpy as np
import pytest

from openrooms_usd.colorimetry import linear_from_srgb, srgb_from_linear
from openrooms_usd.comparison.likeness import likeness


def picture() -> np.ndarray:
    rng = np.random.default_rng(3)
    coarse = rng.uniform(0.05, 0.9, (6, 8, 3))
    return np.round(255 * coarse.repeat(10, axis=0).repeat(10, axis=1)).astype(np.uint8)


def test_gains_of_primaries_do_not_count() -> None:
    """A render of another exposure and white balance is as good as equal."""
    photograph = picture()
    radiance = linear_from_srgb(photograph / 255.0) * [37.0, 11.0, 0.4]
    found = likeness(radiance, photograph)
    assert found.psnr > 45.0
    assert found.ssim == pytest.approx(1.0, abs=1e-3)


def test_noise_of_a_known_size_is_measured() -> None:
    """The mean squared error of values is what PSNR says."""
    photograph = picture()
    sd = 0.05
    noise = np.random.default_rng(4).normal(0.0, sd, photograph.shape)
    shown = np.clip(photograph / 255.0 + noise, 0.0, 1.0)
    expected = -10.0 * np.log10(((shown - photograph / 255.0) ** 2).mean())
    found = likeness(linear_from_srgb(shown), photograph)
    assert found.psnr == pytest.approx(expected, abs=0.2)
    assert found.ssim < 0.98


def test_another_picture_is_unlike() -> None:
    """Turning the picture costs many decibels, and black is finite."""
    photograph = picture()
    assert likeness(linear_from_srgb(photograph[::-1] / 255.0), photograph).psnr < 16.0
    assert np.isfinite(likeness(np.zeros(photograph.shape), photograph).psnr)
    assert srgb_from_linear(np.ones(1))[0] == pytest.approx(1.0)
