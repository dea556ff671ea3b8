"""kill -9 at any moment: the second run leaves the same bytes, and nothing of the first."""

import pytest

from benchmarks.kills import CASES, kills

USUAL = ("render, again",)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [name if name in USUAL else pytest.param(name, marks=pytest.mark.long) for name in CASES],
)
def test_killed_and_run_again(name: str) -> None:
    if name == "simulate":
        pytest.importorskip("mujoco")
    done = list(kills(CASES[name], moments=1, operations=3, seed=1))
    assert len(done) == 4
    assert any(row.in_time for row in done)
    wrong = [f"{row.moment}: {row.refused} {row.differs}" for row in done if row.differs]
    assert wrong + [row.refused for row in done if row.refused] == []
