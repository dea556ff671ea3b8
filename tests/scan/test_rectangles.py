"""Rectangles of the most weight."""

import numpy as np
import pytest

from openrooms_usd.scan.openings.rectangles import Rectangle, best_rectangle, ring


def exhaustive(weights: np.ndarray) -> float:
    total = np.pad(weights.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    rows, columns = total.shape
    return max(
        total[t, r] - total[b, r] - total[t, left] + total[b, left]
        for b in range(rows)
        for t in range(b + 1, rows)
        for left in range(columns)
        for r in range(left + 1, columns)
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_block_among_noise_is_found_to_the_cell(seed: int) -> None:
    random = np.random.default_rng(seed)
    weights = random.normal(-1.0, 0.3, (17, 23))
    bottom, left = random.integers(1, 6, size=2)
    weights[bottom : bottom + 9, left : left + 11] += 2.0
    found, value = best_rectangle(weights)
    assert found == Rectangle(bottom, bottom + 9, left, left + 11)
    assert value == pytest.approx(exhaustive(weights))
    assert value == pytest.approx(weights[found.rows, found.columns].sum())


@pytest.mark.parametrize("shape", [(1, 1), (2, 40), (7, 3), (31, 8)])
def test_everything_is_best_where_everything_is_positive(shape: tuple[int, int]) -> None:
    found, value = best_rectangle(np.ones(shape))
    assert (found.bottom, found.top, found.left, found.right) == (0, shape[0], 0, shape[1])
    assert value == shape[0] * shape[1]


def test_nothing_positive_gives_nothing_positive() -> None:
    assert best_rectangle(-np.ones((12, 12)))[1] < 0


def test_strips_around_a_rectangle_stay_inside() -> None:
    strips = ring((20, 30), Rectangle(0, 10, 5, 29), 3)
    assert strips == {
        "left": Rectangle(0, 10, 2, 5),
        "right": Rectangle(0, 10, 29, 30),
        "top": Rectangle(10, 13, 5, 29),
    }
