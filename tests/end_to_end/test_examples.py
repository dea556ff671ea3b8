"""The numbered examples run as they stand, in a process of their own, and fit on a screen."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))

# What each says when it did what it is about.
SAYS = {
    "01_compose": r"physics +written\n0 findings in scene\.usda",
    "02_read_ground_truth": r"\d{4,} pixels see a surface; .* agree within \d\.\de-0[67] m",
    "03_edit": r"lamp at \(3\.40, 4\.00, .*\n.*\n.*\n.*lamp at \(3\.50, 3\.70, .*\nvase at .*0\.74",
    "04_push": r"carpet +60 N .* 1 ms .*\n(.*\n)+our carpet 0\.\d+: 0\.\d+ m, by Coulomb 0\.\d+ m",
    "05_navigate": r"mean of its pixels: 0\.4\d\d\n(floor 0\.\d+ step \d: .*\n){6}",
    "06_rearrange": r"step 0: .* \d\d cm to go\n(.*\n)*step 3: .*, \d cm to go",
    "07_train": r"\d views, 50 steps: log depth off by [1-9]\.\d\d, then 0\.[0-4]\d",
}


# Robots that navigate or put a room in order take up to a minute.
LONG = ("05_navigate", "06_rearrange")


@pytest.mark.slow
@pytest.mark.parametrize(
    "example",
    [pytest.param(x, marks=pytest.mark.long) if x.stem in LONG else x for x in EXAMPLES],
    ids=lambda path: path.stem,
)
def test_an_example_runs_anywhere(
    example: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    text = example.read_text()
    assert len(text.splitlines()) <= 60
    assert f"Run: python examples/{example.name} OUT" in text
    own = request.getfixturevalue("torch_packages") if "import torch" in text else ""
    done = subprocess.run(
        [sys.executable, "-W", "error", str(example), "out"],
        cwd=tmp_path,
        env={**os.environ, **({"PYTHONPATH": own} if own else {})},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert re.search(SAYS[example.stem], done.stdout), done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_uses_the_front_door_alone(example: Path) -> None:
    imported = set()
    for node in ast.walk(ast.parse(example.read_text())):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            imported |= {f"{node.module}.{alias.name}" for alias in node.names}
    ours = {name for name in imported if name.startswith(("openrooms_usd", "orusd"))}
    assert ours <= {"openrooms_usd", "openrooms_usd.loading", "openrooms_usd.robots"}


def test_every_example_is_known() -> None:
    assert [path.stem for path in EXAMPLES] == list(SAYS)
