"""Features of pictures by closed forms, and the tables of what is published."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.realism.features import colourfulness, features, spectral_slope
from benchmarks.realism.published import NYU40_PER_CENT
from benchmarks.realism.report import distance
from benchmarks.realism.views import pictures, read, total_variation
from openrooms_usd.usd.semantics import NYU40


@pytest.mark.parametrize("slope", [-1.5, -2.0, -2.8])
def test_the_slope_of_a_spectrum_is_that_of_the_noise_it_was_made_by(slope: float) -> None:
    rng = np.random.Generator(np.random.PCG64(1))
    shape = (256, 320)
    frequency = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.fftfreq(shape[1])[None, :])
    frequency[0, 0] = 1.0
    noise = np.fft.fft2(rng.normal(size=shape)) * frequency ** (0.5 * slope)
    assert spectral_slope(np.fft.ifft2(noise).real) == pytest.approx(slope, abs=0.12)


def test_a_grey_ramp_has_no_colour_and_its_tones_are_known() -> None:
    grey = np.repeat(np.repeat(np.arange(256, dtype=np.uint8)[None, :, None], 64, 0), 3, 2)
    found = features(grey)
    assert colourfulness(grey) == 0.0 and found["warmth"] == 0.0
    assert found["clipped share"] == pytest.approx(2 / 256)
    assert found["black share"] == pytest.approx(3 / 256)
    assert found["mean level"] == pytest.approx(0.5)
    assert found["level deviation"] == pytest.approx(np.arange(256).std() / 255)
    # All differences are from left to right.
    assert found["upright share"] == pytest.approx(1.0)


def test_colourfulness_of_two_pure_halves() -> None:
    """Half red, half green: rg is +255 and -255, yb 127.5 throughout."""
    halves = np.zeros((8, 8, 3), np.uint8)
    halves[:, :4, 0], halves[:, 4:, 1] = 255, 255
    assert colourfulness(halves) == pytest.approx(255.0 + 0.3 * 127.5)


def test_noise_fills_patches_that_are_else_empty() -> None:
    flat = np.full((64, 64, 3), 128, np.uint8)
    noise = np.random.Generator(np.random.PCG64(2)).integers(-3, 4, (64, 64, 1))
    assert features(flat)["empty patches"] == 1.0
    assert features((flat + noise).astype(np.uint8))["empty patches"] == 0.0


def test_distances_and_variations() -> None:
    assert distance([3.0, 3.0], [1.0, 2.0, 3.0]) == pytest.approx(1.0 / np.std([1, 2, 3]))
    assert total_variation({"wall": 50.0, "floor": 50.0}, {"wall": 100.0}) == pytest.approx(0.5)
    assert total_variation({"a": 2.0}, {"b": 3.0}) == 1.0


def test_published_classes_are_those_of_nyu40() -> None:
    assert set(NYU40_PER_CENT) == set(NYU40[1:])
    # What is no class of the forty is left out of the hundred.
    assert 75.0 < sum(NYU40_PER_CENT.values()) <= 100.0


def test_real_photographs_are_what_photographs_are(real) -> None:
    """Sixteen photographs of a lounge: no white noise, no flat colour, no clipped frames."""
    found = [features(read(path, 480)) for path in pictures(real("real_dev/data/arkit_lounge"))]
    assert len(found) >= 16
    mean = {name: float(np.mean([row[name] for row in found])) for name in found[0]}
    assert -3.2 < mean["spectral slope"] < -1.6
    assert 5.0 < mean["contrast, stops"] < 11.0
    assert mean["gradient kurtosis"] > 10.0 and mean["clipped share"] < 0.1


def test_pictures_of_a_folder_without_any(tmp_path: Path) -> None:
    assert pictures(tmp_path) == []
