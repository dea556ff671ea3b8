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
    (layout,) = data["layout"]
    assert layout["iou"] > 0.95
    assert data["split"] == "development"
    assert [row["from"] for row in data["alignment"]] == ["pose", "box"]
    assert "## placement" in done.stdout
