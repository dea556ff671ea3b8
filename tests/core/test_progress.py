"""How what takes long says how far it is: fractions that only grow, and end below the whole."""

from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd import adapters
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.exporters import Report, convert_stage
from openrooms_usd.importing import import_capture
from openrooms_usd.progress import Progress, each
from openrooms_usd.rendering import render_stage
from openrooms_usd.rendering.labelling import write_labels
from openrooms_usd.rules import check
from openrooms_usd.usd.files.layers import open_stage

STAGE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{
    def Cube "a"
    {
        double3 xformOp:translate = (0, 0, -5)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Sphere "b"
    {
        double3 xformOp:translate = (1, 1, -5)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Camera "one" {}
    def Camera "two" {}
}
"""
QUICK = RenderSettings(renderer="preview", channels=["instance", "depth"], resolution=(8, 6))


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    (tmp_path / "stage.usda").write_text(STAGE)
    return tmp_path / "stage.usda"


def told(work: Callable[[Progress], object]) -> list[tuple[str, float]]:
    """What a piece of work says of how far it is."""
    said: list[tuple[str, float]] = []
    work(lambda what, fraction: said.append((what, fraction)))
    fractions = [fraction for _, fraction in said]
    assert all(before <= after for before, after in pairwise(fractions))
    assert not fractions or (fractions[0] >= 0.0 and fractions[-1] < 1.0)
    return said


def test_each_of_some_things_is_told_before_it_is_worked_on() -> None:
    assert told(lambda show: list(each(show, "view", "abcd", 4))) == [
        ("view", 0.0),
        ("view", 0.25),
        ("view", 0.5),
        ("view", 0.75),
    ]


@pytest.mark.parametrize(("name", "surfaces"), [("a.glb", 2), ("a.xml", 1)])
def test_convert_tells_each_surface(name: str, surfaces: int, stage: Path, tmp_path: Path) -> None:
    said = told(lambda show: convert_stage(stage, tmp_path / "out" / name, progress=show))
    assert [what for what, _ in said].count("surface") == surfaces


def test_an_exporter_that_tells_nothing_is_asked_for_nothing(
    stage: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Silent:
        def convert(self, stage: Usd.Stage, out: Path, options: Mapping[str, Any]) -> Report:
            return Report()

    monkeypatch.setattr(adapters, "load", lambda group, name: Silent())
    assert told(lambda show: convert_stage(stage, tmp_path / "x", to="x", progress=show)) == []


def test_validate_tells_each_rule(stage: Path) -> None:
    said = told(lambda show: check(open_stage(stage), progress=show))
    assert said[0] == ("rule equal-metadata", 0.0) and len(said) > 20


@pytest.mark.parametrize("form", ["coco", "boxes"])
def test_labels_tell_each_view(form: Any, stage: Path, tmp_path: Path) -> None:
    renders = [tmp_path / "r", tmp_path / "s"] if form == "coco" else [tmp_path / "r"]
    for folder in renders:
        render_stage(stage, folder, QUICK)
    out = tmp_path / "labels.json"
    said = told(lambda show: write_labels(renders, out, form=form, stage=stage, progress=show))
    count = 2 * len(renders)
    assert said == [("view", number / count) for number in range(count)]


def test_import_tells_reading_checking_and_copying(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(0.0, 1.0, (6000, 3))
    sides = np.arange(6000)
    points[sides, sides % 3] = sides // 3 % 2
    np.savetxt(tmp_path / "scan.xyz", points * (4.0, 3.0, 2.6))
    given = {"up": "Z", "unit": "m"}
    said = told(
        lambda show: import_capture("scan", tmp_path / "scan.xyz", tmp_path / "room", given, show)
    )
    steps = ["reading", "finding unit and axes", "placing points", "checking", "copying"]
    assert [what for what, _ in said] == steps
