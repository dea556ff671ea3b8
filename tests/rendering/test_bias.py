"""Bias that is known is found, and none where there is none, however large the noise."""

from collections.abc import Callable

import numpy as np
import pytest

from openrooms_usd.rendering.bias import Bias, SparsePixels, measure

SIZE = (160, 120)
Array = np.ndarray
Planted = Callable[[Array, Array], Array]


def light(x: Array, y: Array) -> Array:
    """A picture of some contrast; places from 0 to 1."""
    return np.exp(np.sin(5 * x) + np.cos(4 * y))


def measured(seed: int, planted: Planted, count: int = 1200, spread: float = 1.0) -> Bias:
    """Of a picture with a planted relative bias, by paths of which few are bright."""
    rng = np.random.default_rng(seed)
    pixels = SparsePixels.draw(*SIZE, count, rng)
    rows, columns = np.divmod(pixels.numbers, SIZE[0])
    x, y = (columns + 0.5) / SIZE[0], (rows + 0.5) / SIZE[1]
    shape = (len(x), 3)
    noise = np.exp(spread * rng.standard_normal(shape) - spread**2 / 2)
    truth = light(x, y)[:, None] * np.array([1.0, 0.8, 0.5])
    found = truth * (1 + planted(x, y)[:, None]) * (1 + 0.2 * rng.standard_normal(shape))
    bias = measure(found, truth * noise, pixels, truth.sum(axis=1))
    assert bias
    return bias


def true_total(planted: Planted) -> float:
    x, y = np.meshgrid(*((np.arange(n) + 0.5) / n for n in SIZE))
    return float((planted(x, y) * light(x, y)).sum() / light(x, y).sum())


PLANTED: dict[str, Planted] = {
    "none": lambda x, y: 0.0 * x,
    "everywhere": lambda x, y: 0.0 * x - 0.1,
    "a corner": lambda x, y: np.where((x < 0.4) & (y < 0.25), 0.5, 0.0),
}


@pytest.mark.parametrize("name", PLANTED)
def test_the_total_is_right_within_its_error(name: str) -> None:
    found = [measured(seed, PLANTED[name]) for seed in range(60)]
    deviations = [(one.total - true_total(PLANTED[name])) / one.total_error for one in found]
    assert abs(np.mean(deviations)) < 4 / 60**0.5
    assert 0.7 < np.std(deviations) < 1.3


def test_where_there_is_no_bias_the_worst_tenth_has_none() -> None:
    """The worst tenth of what is noise alone would be far from 0, were it chosen by itself."""
    found = [measured(seed, PLANTED["none"]) for seed in range(60)]
    worst = np.array([one.worst_tenth for one in found])
    errors = np.array([one.worst_tenth_error for one in found])
    assert abs(worst.mean()) < 4 * worst.std() / 60**0.5
    assert np.mean(np.abs(worst) > 2 * errors) < 0.15


def test_the_worst_tenth_is_found_where_paths_can_tell() -> None:
    found = [measured(seed, PLANTED["a corner"], 4000, 0.5) for seed in range(10)]
    worst = np.mean([one.worst_tenth for one in found])
    assert worst == pytest.approx(0.5, abs=0.05)
    assert np.mean([one.total for one in found]) < 0.5 * worst
    # The sign does not matter, and dark places do not hide behind bright ones.
    dark = [measured(s, lambda x, y: -0.5 * PLANTED["a corner"](x, y), 4000, 0.5) for s in range(9)]
    assert np.mean([one.worst_tenth for one in dark]) == pytest.approx(0.25, abs=0.05)


@pytest.mark.parametrize("size", [(160, 120), (7, 5), (1, 1), (3, 200)])
@pytest.mark.parametrize("count", [1, 30, 500, 10**6])
def test_every_pixel_can_be_drawn_and_stands_for_all(size: tuple[int, int], count: int) -> None:
    pixels = SparsePixels.draw(*size, count, np.random.default_rng(count))
    assert pixels.weights.sum() == size[0] * size[1]
    assert len(np.unique(pixels.numbers)) == len(pixels.numbers) <= size[0] * size[1]
    assert pixels.numbers.max() < size[0] * size[1]
    assert len(pixels.numbers) <= 2 * count + 1


def test_weights_make_sums_of_sparse_pixels_unbiased() -> None:
    picture = np.arange(70.0) ** 2
    sums = []
    for seed in range(400):
        pixels = SparsePixels.draw(10, 7, 20, np.random.default_rng(seed))
        sums.append((pixels.weights * picture[pixels.numbers]).sum())
    assert np.mean(sums) == pytest.approx(picture.sum(), rel=0.01)


def test_what_cannot_be_said_is_not_said() -> None:
    pixels = SparsePixels.draw(*SIZE, 1000, np.random.default_rng(0))
    shape = (len(pixels.numbers), 3)
    dark, bright = np.zeros(shape), np.random.default_rng(1).random(shape)
    level = bright.sum(axis=1)
    off = measure(dark, dark, pixels, 0.0 * level)
    assert off and (off.total, off.total_error, off.worst_tenth) == (0.0, 0.0, 0.0)
    # A lamp that no path of the reference has met, or one alone.
    assert measure(bright, dark, pixels, level) is None
    lucky = dark.copy()
    lucky[7] = 100.0
    assert measure(bright, lucky, pixels, level) is None
    # Few pixels have no worst tenth, unless each tells much.
    few = SparsePixels.draw(*SIZE, 200, np.random.default_rng(0))
    some = np.random.default_rng(2).random((2, len(few.numbers), 3))
    for paths, has in ((1, False), (500, True)):
        told = measure(*some, few, level[: len(few.numbers)], paths)
        assert told and (told.worst_tenth is not None) is has
