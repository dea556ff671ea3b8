"""Two stages at equal error: twice the seconds at half the error cost the same."""

import numpy as np
import pytest

from benchmarks.against import compared


class Fake:
    """Renders a grey picture with noise that falls with the samples."""

    def __init__(self, seconds: float, noise: float) -> None:
        self.seconds, self.noise = seconds, noise

    def render(self, method: str, samples: int, seed: int) -> tuple[float, np.ndarray]:
        rng = np.random.default_rng(seed)
        spread = self.noise / np.sqrt(samples)
        return self.seconds, 1.0 + spread * rng.standard_normal((60, 80, 3))


@pytest.mark.parametrize(("seconds", "noise", "ratio"), [(2.0, 1.0, 2.0), (2.0, 0.5**0.5, 1.0)])
def test_seconds_at_equal_error(seconds: float, noise: float, ratio: float) -> None:
    sides = {"before": Fake(1.0, 1.0), "after": Fake(seconds, noise)}
    rows = compared(sides, samples=64, reference=1_000_000, rounds=3)
    assert [row["method"] for row in rows] == ["reference", "cache"]
    for row in rows:
        assert row["ratio"] == pytest.approx(ratio, rel=0.02)
        assert row["robust_ratio"] == pytest.approx(ratio, rel=0.02)
