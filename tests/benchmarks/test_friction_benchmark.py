"""The friction benchmark runs, and its figures agree with what they are made of."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_it_runs(tmp_path):
    target = tmp_path / "f.json"
    command = [sys.executable, "-m", "benchmarks.friction", "--json", str(target)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    data = json.loads(target.read_text())
    error = {row["known"]: row["mean absolute error"] for row in data["left_out"]}
    assert error["nothing"] > error["substance"] > error["counterface, substance"]
    assert all(0.05 < value < 0.3 for value in error.values())
    assert {row["paper"] for row in data["paper"]} == {0.76, 0.31}
    assert "Each specimen left out" in done.stdout
