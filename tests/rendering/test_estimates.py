"""How far pictures are from the truth."""

import numpy as np
import pytest

from openrooms_usd.rendering import rare_light
from openrooms_usd.rendering.estimates import (
    ErrorEstimate,
    estimate,
    estimate_of_ratio,
    relative_mse,
    robust_error,
)


def test_errors_against_a_reference_are_those_of_the_conventions():
    """Two pixels of one component, reference 1 and 3: M = 2, so scales are 1.04 and 9.04."""
    reference = np.array([[[1.0], [3.0]]])
    picture = np.array([[[1.5], [11.0]]])
    near, far = 0.25 / 1.04, 64.0 / 9.04
    assert relative_mse(picture, reference) == pytest.approx((near + far) / 2)
    assert robust_error(picture, reference) == pytest.approx((near + 1.0) / 2)


@pytest.mark.parametrize("factor", [0.5, 1.1, 3.0])
def test_a_common_factor_is_an_error_in_every_color(factor: float) -> None:
    reference = np.full((5, 6, 3), [1.0, 2.0, 4.0])
    assert relative_mse(factor * reference, reference) == pytest.approx((factor - 1) ** 2 / 1.01)


def test_a_pixel_costs_the_robust_error_its_share_at_most():
    reference = np.ones((10, 10, 3))
    spiked = reference.copy()
    spiked[0, 0] = 1e9
    assert robust_error(spiked, reference) == pytest.approx(0.01)
    assert relative_mse(spiked, reference) > 1e15


def test_errors_do_not_depend_on_the_unit_and_a_dark_component_has_none():
    rng = np.random.default_rng(0)
    reference, picture = rng.random((2, 6, 8, 3))
    reference[..., 2] = 0.0
    for figure in (relative_mse, robust_error):
        assert figure(1000.0 * picture, 1000.0 * reference) == pytest.approx(
            figure(picture, reference)
        )
        lit = figure(picture[..., :2], reference[..., :2])
        assert figure(picture, reference) == pytest.approx(lit * 2 / 3)
        assert figure(reference, reference) == 0.0


def halves_of(draw, mean, samples, seed):
    """Two halves of a picture of random paths, and its true errors."""
    rng = np.random.default_rng(seed)
    a, b = (draw(rng, (samples, *mean.shape)).mean(axis=0) for _ in range(2))
    picture = (a + b) / 2
    return a, b, relative_mse(picture, mean), robust_error(picture, mean)


def ordinary(rng, shape):
    """Paths of brightness 1, give or take."""
    return rng.gamma(4.0, 0.25, shape)


def rare(chance, brightness=1.0):
    """Paths of brightness 1, and rarely of as much light together as all others."""
    return lambda rng, shape: (
        ordinary(rng, shape) + np.where(rng.random(shape) < chance, brightness / chance, 0.0)
    )


def pareto(rng, shape):
    """Paths whose mean is 1 and whose variance has no bound."""
    return (rng.pareto(1.5, shape) + 1.0) / 3.0


def test_ordinary_noise_is_estimated_as_it_is():
    """Gamma with variance 1/4 about 1: the closed form is 1/4 / 32 / 1.01."""
    mean = np.ones((48, 64, 3))
    a, b, made, robust = halves_of(ordinary, mean, 16, 0)
    found = estimate(a, b)
    assert made == pytest.approx(0.25 / 32 / 1.01, rel=0.05)
    assert found.relative_mse == pytest.approx(made, rel=0.2)
    assert found.robust == pytest.approx(robust, rel=0.2)


@pytest.mark.parametrize("chance", [1e-2, 1e-3, 1e-4])
def test_rare_bright_paths_are_estimated_by_the_closed_form(chance):
    """Of paths with the chance p and the brightness 1 / p the variance is (1 - p) / p."""
    mean = np.full((48, 64, 3), 2.0)
    a, b, *_ = halves_of(rare(chance), mean, 8, 1)
    expected = ((1 - chance) / chance + 0.25) / 16 / (1.01 * 4.0)
    assert 0.5 * expected < estimate(a, b).relative_mse < 3.0 * expected


def by_the_picture(a, b):
    """What hides rare paths: the picture itself as the scale of its error."""
    mean = (a + b) / 2
    return float(np.mean((a - b) ** 2 / 4 / (mean**2 + 0.01 * mean.mean(axis=(0, 1)) ** 2)))


@pytest.mark.parametrize(
    ("draw", "level", "hidden"),
    [
        (ordinary, 1.0, False),
        (pareto, 1.0, True),
        (rare(3e-3), 2.0, True),
        (rare(1e-2), 2.0, True),
        (rare(3e-2), 2.0, True),
    ],
)
def test_hardly_any_true_error_is_more_than_twice_the_estimate(draw, level, hidden):
    """Of rare paths a picture meets from 20 to 200; a scale by the picture would hide them."""
    mean = np.full((24, 32, 1), level)
    told, by_picture = [], []
    for seed in range(60):
        a, b, made, robust = halves_of(draw, mean, 4, seed)
        found = estimate(a, b)
        told.append((made / found.relative_mse, robust / found.robust))
        by_picture.append(made / by_the_picture(a, b))
    assert (np.array(told) > 2.0).mean(axis=0).max() < 0.05
    assert np.median(told, axis=0).min() > 0.2
    assert (np.mean(np.array(by_picture) > 2.0) > 0.9) == hidden


def test_a_picture_of_which_few_pixels_have_met_light_says_so():
    """Each path brings light with a chance of 1 in 100: nearly all pixels are black."""
    mean = np.ones((24, 32, 3))
    a, b, _, robust = halves_of(lambda r, s: 100.0 * (r.random(s) < 0.01), mean, 2, 0)
    assert np.mean(a + b == 0.0) > 0.95
    assert robust > 0.9
    assert estimate(a, b).robust == pytest.approx(robust, abs=0.1)


def test_sharp_edges_are_no_rare_light():
    """A lamp before black, its edge half in a row of pixels."""
    a = np.zeros((24, 32, 3))
    a[:8], a[8] = 100.0, 50.0
    b = a.copy()
    b[8] = 45.0
    made = np.mean((a - b) ** 2 / 4 / (47.5**2 + 0.01 * a.mean() ** 2))
    found = estimate(a, b)
    assert made < found.robust < 2.0 * made
    assert made < found.relative_mse < 2.0 * made


def test_nothing_is_told_of_light_that_no_sample_has_met():
    dark = np.zeros((6, 8, 3))
    assert estimate(dark, dark) == ErrorEstimate(None, None)
    assert estimate(dark + 1.0, dark + 1.0) == ErrorEstimate(0.0, 0.0)


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 7, 1), (5, 9, 3), (17, 33, 2)])
def test_estimates_depend_neither_on_the_unit_nor_on_the_order_of_halves(shape):
    rng = np.random.default_rng(2)
    a, b = rng.pareto(2.0, (2, *shape))
    found = estimate(a, b, 3, 2)
    assert 0.0 <= found.robust <= 1.0
    for other in (estimate(b, a, 2, 3), estimate(2.0**60 * a, 2.0**60 * b, 3, 2)):
        assert other.relative_mse == pytest.approx(found.relative_mse, rel=1e-5)
        assert other.robust == pytest.approx(found.robust, rel=1e-5)


def test_what_was_met_once_may_be_anywhere_and_what_was_met_often_is_there():
    once = np.zeros((16, 16, 1), np.float32)
    once[3, 5] = 256.0
    assert np.allclose(rare_light.spread(once), 1.0)  # The mean, and as much may be wrong.
    often = np.zeros((16, 16, 1), np.float32)
    often[2:4, 4:6] = 7.0
    found, unsure = rare_light.spread(often)
    assert np.allclose(found[2:4, 4:6], 7.0)
    # A block about others has met four paths if it is so large.
    assert found[2, 2, 0] == 4 * 7.0 / 64
    assert found[15, 15, 0] == 4 * 7.0 / 256
    assert np.allclose(unsure, found / 2)


def test_what_neighbours_or_both_halves_have_is_supported():
    rng = np.random.default_rng(3)
    a, b = rng.random((2, 7, 9, 3)).astype(np.float32)
    mean = (a + b) / 2
    found = rare_light.supported(a, b, mean)
    padded = np.pad(mean, ((1, 1), (1, 1), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (3, 3), axis=(0, 1))
    median = np.median(windows, axis=(-2, -1))
    assert np.array_equal(found, np.minimum(mean, np.maximum(np.minimum(a, b), median)))


def _lit(samples: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Visible and all samples of a lamp in each half, and what part of a pixel it lights.

    A disc is in shadow; of its rim a part of each pixel is lit, or faces the lamp at all.
    """
    y, x = np.mgrid[:24, :32]
    rim = 10.0 - np.hypot(x - 15.3, y - 11.7)
    share = np.clip(0.5 - 0.7 * rim, 0.0, 1.0)[..., None]
    facing = np.where(share == 0.0, 0.0, np.clip(share + 0.3, 0.0, 1.0))
    whole = rng.binomial(samples, facing, (2, *facing.shape)).astype(float)
    lit = rng.binomial(whole.astype(int), np.where(facing > 0.0, share, 0.0)).astype(float)
    return lit, whole, np.where(facing > 0.0, share, 0.0)


def _ratio(lit: np.ndarray, whole: np.ndarray) -> np.ndarray:
    return np.divide(lit, whole, out=np.zeros_like(lit), where=whole > 0.0)


@pytest.mark.parametrize("samples", [2, 8])
def test_of_a_ratio_more_is_unsure_than_halves_can_tell(samples: int) -> None:
    """Where no sample of an edge faces the lamp both halves say 0, and are wrong alike."""
    rng = np.random.default_rng(3)
    plain, ours = [], []
    for _ in range(60):
        lit, whole, truth = _lit(samples, rng)
        picture = _ratio(lit.sum(axis=0), whole.sum(axis=0))
        halves = _ratio(lit, whole)
        made = relative_mse(picture, truth)
        told = estimate_of_ratio(picture, *halves, samples, samples).relative_mse
        plain.append((estimate(*halves, samples, samples).relative_mse or 0.0) / made)
        ours.append((told or 0.0) / made)
    assert np.mean(np.array(ours) < 0.5) <= 0.05
    assert np.median(ours) < 4.0 and np.median(ours) > np.median(plain)


def test_of_a_mean_the_estimate_of_a_ratio_is_the_same_but_at_edges() -> None:
    rng = np.random.default_rng(4)
    a, b = 1.0 + 0.2 * rng.standard_normal((2, 24, 32, 3))
    told, same = estimate_of_ratio((a + b) / 2, a, b, 8, 8), estimate(a, b, 8, 8)
    assert told.relative_mse and same.relative_mse
    assert same.relative_mse < told.relative_mse < 1.05 * same.relative_mse
