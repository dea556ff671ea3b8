"""``--report``: what became of every prim, and the frame, as a file; misplaced ones are refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.errors import OutputError
from tests.commands import run

STAGE = """#usda 1.0
(
    metersPerUnit = 0.1
    upAxis = "Y"
)
def Xform "World"
{
    def Cube "Box" {}
    def Sphere "Hidden"
    {
        token visibility = "invisible"
    }
    def DistantLight "Sun" {}
}
"""


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    path = tmp_path / "scene.usda"
    path.write_text(STAGE)
    return path


def _run(command: str, stage: Path, out: Path, report: Path, *more: str) -> Any:
    asked = [str(out)] if command == "convert" else ["-o", str(out), *more]
    return run(command, stage, *asked, "--report", report)


RENDER = ("--resolution", "8x8", "--channels", "depth", "--renderer", "preview")


@pytest.mark.parametrize(("command", "out"), [("convert", "box.glb"), ("render", "out")])
def test_every_prim_and_the_frame(stage: Path, tmp_path: Path, command: str, out: str) -> None:
    for name in ("a", "b"):
        done = _run(command, stage, tmp_path / out, tmp_path / f"to/{name}.json", *RENDER)
        assert done.exit_code == 0, done.output
    text = (tmp_path / "to/a.json").read_bytes()
    assert text == (tmp_path / "to/b.json").read_bytes()
    assert str(tmp_path).encode() not in text
    told = json.loads(text)
    assert list(told) == ["entries", "world_from_stage"]
    found = {row["prim"]: (row["outcome"], row["reason"]) for row in told["entries"]}
    assert found["/World/Hidden"] == ("skipped", "invisible")
    assert {"/World/Box", "/World/Sun"} < set(found)
    # A point 10 units up and 20 to the viewer is a metre up and two metres towards -y.
    moved = np.array(told["world_from_stage"]) @ [0.0, 10.0, 20.0, 1.0]
    assert moved == pytest.approx([0.0, -2.0, 1.0, 1.0])


@pytest.mark.parametrize("command", ["convert", "render"])
@pytest.mark.parametrize(
    ("place", "why"),
    [
        ("scene.usda", "the stage"),
        ("link.usda", "the stage"),
        ("out.xml", "the output"),
        ("out.xml/deep/a.json", "the output"),
        ("folder", "a folder"),
        ("scene.usda/a.json", "a"),
    ],
)
def test_a_misplaced_report_is_refused_before_anything_is_written(
    stage: Path, tmp_path: Path, command: str, place: str, why: str
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "link.usda").symlink_to(stage)
    there = sorted(tmp_path.iterdir())
    refused = _run(command, stage, tmp_path / "out.xml", tmp_path / place, *RENDER)
    assert isinstance(refused.exception, OutputError), refused.output
    assert why in str(refused.exception)
    assert sorted(tmp_path.iterdir()) == there and stage.read_text() == STAGE


@pytest.mark.parametrize("more", [("--time-codes", "1:2:1"), ("--path", "walk")])
def test_frames_have_manifests_instead(stage: Path, tmp_path: Path, more: tuple[str, ...]) -> None:
    refused = _run("render", stage, tmp_path / "out", tmp_path / "a.json", *more)
    assert refused.exit_code == 2 and "--report" in refused.output
