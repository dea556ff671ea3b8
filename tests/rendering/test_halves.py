"""Halves of pictures, as they are kept."""

import numpy as np
import pytest

from openrooms_usd.rendering.estimates import Halves
from openrooms_usd.rendering.halves import HalvedPicture, KeptHalves


def noisy(scale: float) -> Halves:
    random = np.random.default_rng(4)
    truth = scale * 10.0 ** random.uniform(-3, 3, (12, 16, 3))
    a, b = (truth * (1 + spread * random.standard_normal(truth.shape)) for spread in (0.3, 0.1))
    return Halves(a, b, (5, 3))


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e6])
def test_errors_and_deviations_are_those_of_the_halves(scale: float) -> None:
    halves = noisy(scale)
    pixels = ((5 * halves.a + 3 * halves.b) / 8).astype(np.float32)
    kept = KeptHalves.made(pixels, halves)
    assert kept.estimate.relative_mse == pytest.approx(halves.error, rel=1e-3)
    assert kept.estimate.robust == pytest.approx(halves.robust_error, rel=1e-3)
    apart = np.abs(kept.deviation[2:9] - halves.deviation[2:9])
    assert (apart <= 1e-3 * pixels[2:9]).all()
    assert kept.deviation.shape == pixels.shape
    assert kept.a.nbytes + kept.b.nbytes == pixels.nbytes


def test_strips_fill_up_to_the_whole_and_what_is_no_mean_of_them_keeps_them() -> None:
    """A ratio's picture need not lie between those of its halves."""
    halves = noisy(1.0)
    pixels = (1.7 * halves.b).astype(np.float32)
    pixels[0, 0] = 0.0
    whole, strips = KeptHalves.made(pixels, halves), HalvedPicture.blank(pixels)
    for rows in (slice(0, 5), slice(5, 12)):
        strips.fill(rows, halves.a[rows], halves.b[rows])
    kept = strips.of(halves.samples)
    assert np.array_equal(kept.halves.a, whole.halves.a)
    np.testing.assert_allclose(kept.halves.a[1:], halves.a[1:], rtol=1e-2)
    np.testing.assert_allclose(kept.halves.b[1:], halves.b[1:], rtol=1e-2)
    assert kept.halves.a[0, 0].tolist() == [0.0] * 3
