"""The benchmark of scans runs, and our rooms are right where a scan is easy."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.long
def test_scan(tmp_path):
    pytest.importorskip("embreex")
    pytest.importorskip("fcl")
    target = tmp_path / "scan.json"
    command = [sys.executable, "-m", "benchmarks.scan", "--quick", "--json", str(target)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    data = json.loads(target.read_text())
    ours = data["layout"][0]
    assert ours["method"] == "ours" and ours["iou"] > 0.95
    assert data["split"] == "development"
    starts = {(row["from"], row["method"]) for row in data["alignment"]}
    assert {("pose", "ours"), ("box", "ours"), ("box", "grid in the box")} <= starts
    assert [row["points"] for row in data["growth"]] == [10_000, 100_000]
    hard = {row["case"]: row for row in data["hard cases"]}
    assert all(row["as_it_should"] for row in hard.values())
    assert hard["empty cloud"]["outcome"].startswith("refused")
    assert len(data["hard contacts"]) == 2
    assert "## placement" in done.stdout
