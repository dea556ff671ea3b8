"""The friction benchmark runs, and its figures agree with what they are made of."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import spearmanr

from benchmarks.friction import rank_correlation

ROOT = Path(__file__).parents[2]


def test_ranks_against_scipy():
    rng = np.random.default_rng(0)
    a, b = rng.integers(0, 5, 30).astype(float), rng.random(30)
    assert abs(rank_correlation(a, b) - spearmanr(a, b).statistic) < 1e-12
    assert np.isnan(rank_correlation(np.ones(4), np.arange(4.0)))


@pytest.mark.slow
def test_it_runs(tmp_path):
    target = tmp_path / "f.json"
    command = [sys.executable, "-m", "benchmarks.friction", "--quick", "--json", str(target)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    data = json.loads(target.read_text())
    error = {row["known"]: row["mean absolute error"] for row in data["left_out"]}
    assert error["nothing"] > error["substance"] > error["counterface, substance"]
    assert all(0.05 < value < 0.3 for value in error.values())
    assert {row["paper"] for row in data["paper"]} == {0.76, 0.31}
    assert 0 < data["chance"] <= 1
    assert "Each specimen left out" in done.stdout
