"""The colour pipeline against closed forms and its own promises."""

import math

import numpy as np
import pytest

from openrooms_usd.rendering import color


def decoded(code: float) -> float:
    """IEC 61966-2-1 from the display's side: code value to light."""
    return code / 12.92 if code <= 0.04045 else ((code + 0.055) / 1.055) ** 2.4


def luminance_of_bytes(rgb: np.ndarray) -> np.ndarray:
    light = np.vectorize(decoded)(rgb / 255)
    return light @ [0.2126, 0.7152, 0.0722]


def test_quantize_rounds_to_the_nearest_step():
    steps = np.arange(256) / 255
    assert color.quantize(steps).tolist() == list(range(256))
    assert color.quantize(steps[1:] - 0.4 / 255).tolist() == list(range(1, 256))
    assert color.quantize(np.array([np.nan, np.inf, -np.inf, -3, 7])).tolist() == [0, 0, 0, 0, 255]


def test_film_keeps_middle_grey_and_rises():
    grey = np.repeat(0.18 * 2 ** np.linspace(-9.9, 6.4, 400)[:, None], 3, axis=1)
    shown = color.film(grey)
    assert np.all(np.diff(shown, axis=0) > 0)
    assert np.ptp(shown, axis=1).max() < 1e-6  # grey stays grey
    assert color.film(np.full((1, 3), 0.18)) == pytest.approx(0.18, rel=1e-3)
    ends = color.film(np.array([[0, 0, 0], [1e9, 1e9, 1e9]]))
    assert ends[0].max() < 1e-9
    assert ends[1].min() > 0.999


def test_film_fades_bright_colours_to_white():
    red = np.array([[1.0, 0.1, 0.1]]) * np.array([[0.1], [1], [10], [100]])
    shown = color.film(red)
    saturation = 1 - shown.min(axis=1) / shown.max(axis=1)
    assert np.all(np.diff(saturation) < 0)
    assert shown.min() >= 0
    assert shown.max() <= 1


def in_blocks(luminance: np.ndarray) -> np.ndarray:
    """Every value as 8x8 grey pixels."""
    return np.repeat(np.kron(luminance, np.ones((8, 8)))[..., None], 3, axis=2)


def test_exposure_brings_the_log_average_to_the_key():
    luminance = np.exp(np.random.default_rng(3).uniform(-1, 5, (40, 50)))
    factor = color.fitted_exposure(in_blocks(luminance))
    logs = sorted(math.log(value) for value in luminance.flat)
    trimmed = [min(max(value, logs[100]), logs[-100]) for value in logs]
    assert factor == pytest.approx(0.27 / math.exp(sum(trimmed) / len(trimmed)), rel=1e-3)
    assert color.fitted_exposure(7 * in_blocks(luminance)) == pytest.approx(factor / 7, rel=1e-5)


def test_exposure_hardly_depends_on_noise():
    rng = np.random.default_rng(4)
    clean = in_blocks(np.exp(rng.uniform(0, 3, (30, 40))))
    noisy = clean * rng.exponential(1.0, clean.shape[:2])[..., None]
    assert color.fitted_exposure(noisy) == pytest.approx(color.fitted_exposure(clean), rel=0.02)


@pytest.mark.parametrize("shape", [(1, 1), (3, 100), (100, 3), (8, 8), (17, 31)])
def test_exposure_of_a_flat_picture_of_any_size(shape):
    flat = np.full((*shape, 3), 54.0, np.float32)
    assert color.fitted_exposure(flat) == pytest.approx(0.27 / 54, rel=1e-4)


def test_exposure_ignores_a_lamp_and_nonsense():
    radiance = np.full((80, 80, 3), 80.0, np.float32)
    plain = color.fitted_exposure(radiance)
    radiance[:8, :8] = 1e6
    radiance[-1] = np.nan
    assert color.fitted_exposure(radiance) == pytest.approx(plain, rel=1e-6)
    assert color.fitted_exposure(np.zeros((4, 4, 3))) == 1


def test_ramp_darkens_evenly():
    steps = color.quantize(color.ramp(np.linspace(0, 1, 64)))
    light = luminance_of_bytes(steps)
    lightness = np.cbrt(light)
    assert np.all(np.diff(light) < 0)
    assert np.abs(np.diff(lightness) / np.diff(lightness).mean() - 1).max() < 0.75
    assert light[0] > 0.7
    assert light[-1] < 0.05


def test_palette_tells_numbers_apart():
    colors = color.palette(np.arange(256)).astype(int)
    apart = np.abs(colors[:, None] - colors[None]).sum(axis=-1) + 999 * np.eye(256, dtype=int)
    assert apart.min() >= 6
    assert apart[:46, :46].min() >= 24  # the classes of the semantic channel
    assert colors[0].tolist() == [0, 0, 0]


def test_palette_depends_on_the_number_alone():
    some = np.array([[7, 0], [3, 2**24 - 1]])
    assert np.array_equal(color.palette(some)[0, 0], color.palette(np.arange(9))[7])
    assert np.array_equal(color.palette(some[::-1])[::-1], color.palette(some))
