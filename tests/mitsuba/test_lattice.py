"""Samples of a pixel are spread over every dimension, and each of them is as random as ever."""

from typing import Any

import numpy as np
import pytest
from scipy.stats import kstest

from openrooms_usd.arrays import Array

PIXELS = 3000


@pytest.fixture
def draw(vectorized: str) -> Any:
    """The seven numbers of each sample: (7, PIXELS, samples)."""
    import mitsuba as mi

    mi.set_variant(vectorized)
    from orusd_mitsuba.transport.lattice import FirstDimensions

    def drawn(samples: int, seed: int = 0) -> Array:
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, PIXELS)
        found = FirstDimensions(samples, PIXELS * samples, sampler)
        rows = [found.light.numpy(), found.direction.numpy(), found.pixel.numpy()]
        flat = np.concatenate([*rows, found.lobe.numpy()[None]])
        return flat.reshape(7, PIXELS, samples).astype(np.float64)

    return drawn


@pytest.mark.parametrize("samples", [5, 16, 100])
def test_gaps_between_the_samples_of_a_pixel_are_even(draw: Any, samples: int) -> None:
    found = np.sort(draw(samples), axis=2)
    around = np.concatenate([found, found[..., :1] + 1.0], axis=2)
    # Independent samples leave gaps of about log(n) / n.
    assert (np.diff(around, axis=2).max(axis=(1, 2)) < 3.0 / samples).all()


@pytest.mark.parametrize("samples", [1, 2, 16])
def test_a_sample_by_itself_is_uniform_and_its_dimensions_know_nothing_of_each_other(
    draw: Any, samples: int
) -> None:
    found = draw(samples, 3)
    assert found.min() >= 0.0 and found.max() < 1.0
    for number in {0, samples - 1}:
        one = found[:, :, number]
        assert min(kstest(values, "uniform").pvalue for values in one) > 1e-4
        common = np.corrcoef(one) - np.eye(7)
        assert np.abs(common).max() < 5.0 / np.sqrt(PIXELS)
        # Neighbours, too, know nothing of each other.
        beside = [np.corrcoef(values[1:], values[:-1])[0, 1] for values in one]
        assert np.abs(beside).max() < 5.0 / np.sqrt(PIXELS)


def test_equal_seeds_give_equal_numbers_and_others_do_not(draw: Any) -> None:
    found, again, other = draw(16, 1), draw(16, 1), draw(16, 2)
    assert np.array_equal(found, again)
    common = [np.corrcoef(a.ravel(), b.ravel())[0, 1] for a in found for b in other]
    assert np.abs(common).max() < 5.0 / np.sqrt(PIXELS)


def test_a_smooth_integral_is_less_noisy_than_with_independent_samples(draw: Any) -> None:
    found = draw(16)
    for pair in (found[0:2], found[2:4], found[4:6]):
        means = pair.prod(axis=0).mean(axis=1)
        assert means.mean() == pytest.approx(0.25, abs=5 * means.std() / np.sqrt(PIXELS))
        assert means.var() < 0.25 * (1 / 9 - 1 / 16) / 16
