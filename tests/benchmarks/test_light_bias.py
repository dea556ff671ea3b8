"""Figures of the benchmark of light: bias is told from noise, and a reference from its own."""

from typing import Any

import numpy as np
import pytest

from openrooms_usd.arrays import Array

SIZE = (48, 64, 3)
Pictures = Array


def noisy(mean: Pictures, spread: float, seed: int) -> tuple[Pictures, Pictures]:
    """Two halves about a mean, each with relative noise of its own."""
    numbers = np.random.default_rng(seed)
    one, other = (mean * (1.0 + spread * numbers.standard_normal(mean.shape)) for _ in range(2))
    return one, other


@pytest.fixture
def truth() -> Any:
    return np.random.default_rng(1).uniform(0.5, 2.0, SIZE)


def test_noise_is_no_bias(truth: Pictures) -> None:
    from benchmarks.light.bias import bias_of

    found = bias_of(noisy(truth, 0.3, 2), noisy(truth, 0.2, 3))
    assert abs(found.total) < 4.0 * found.deviation < 0.03
    assert abs(found.worst) < 4.0 * found.worst_deviation < 0.1


def test_a_dark_corner_is_found_beneath_the_noise(truth: Pictures) -> None:
    from benchmarks.light.bias import bias_of

    dark = truth.copy()
    dark[:12, :16] *= 0.8
    found = bias_of(noisy(dark, 0.02, 2), noisy(truth, 0.02, 3))
    expected = dark.mean() / truth.mean() - 1.0
    assert found.total == pytest.approx(expected, abs=4.0 * found.deviation)
    # A sixteenth of the picture is 20 % too dark: it is in the worst tenth, the rest is right.
    assert 0.1 < found.worst < 0.2


def test_a_reference_adds_nothing_to_the_error(truth: Pictures) -> None:
    from benchmarks.light.bias import mse_of, robust_of

    picture, _ = noisy(truth, 0.1, 2)
    expected = mse_of(picture, (truth, truth))
    assert expected == pytest.approx(0.01, rel=0.1)
    halves = noisy(truth, 0.1, 3)
    assert mse_of(picture, halves) == pytest.approx(expected, rel=0.1)
    assert robust_of(picture, halves) == pytest.approx(expected, rel=0.1)


def test_views_share_what_their_room_takes() -> None:
    from benchmarks.light.sessions import Cost

    assert Cost(room=10.0, view=1.0).views(1) == 11.0
    assert Cost(room=10.0, view=1.0).views(20) == 1.5


def test_a_reference_is_made_once(tmp_path: Any) -> None:
    from benchmarks.light.hard import CASES
    from benchmarks.light.sessions import References
    from openrooms_usd.rendering.scene.translate import translate

    made: list[int] = []

    def make(half: int) -> dict[str, Pictures]:
        made.append(half)
        return {"radiance": np.full((2, 2, 3), float(half))}

    def pair(case: str, samples: int) -> Any:
        scene = translate(CASES[case].build(tmp_path))
        return References(tmp_path).pair(scene, {"samples": samples}, make)

    for _ in range(2):
        a, b = pair("plain", 4)
        assert a["radiance"].max() == 0.0 and b["radiance"].min() == 1.0
    assert made == [0, 1]
    pair("plain", 8), pair("black", 4)
    assert made == [0, 1] * 3
