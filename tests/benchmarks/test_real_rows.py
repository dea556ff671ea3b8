"""The benchmark of real captures: what it runs, how it adds up, and one small capture whole."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tests.benchmarks.test_real_scores import found, hole, written

ROOT = Path(__file__).parents[2]
TABLE = {"table": {"chair": ["chair"]}}


@pytest.fixture
def data(tmp_path):
    """A folder with one scan, whose truth is a room of 4 m by 3 m."""
    (tmp_path / "truth").mkdir()
    written(tmp_path / "truth")
    (tmp_path / "truth" / "substitutes.json").write_text(json.dumps(TABLE))
    words = ["scan", "data/room/scan.ply"]
    stripped = {"import": words, "strip": True}
    runs = {"plain": {"import": words, "labels": True}, "nolabels": stripped}
    listed = {"room": {"kind": "scan", "runs": runs}, "absent": {"kind": "scan", "runs": runs}}
    (tmp_path / "captures.json").write_text(json.dumps(listed))
    return tmp_path


def captures(data, **options):
    from benchmarks.real.captures import captures_of

    return list(captures_of(data, **options))


def row(data, run=0, *, rooms=(), said="", seconds=1.0):
    """A run that left these rooms, or none."""
    from benchmarks.real.rows import score
    from benchmarks.real.running import Outcome

    capture = captures(data)[0]
    folder = data / f"out{run}"
    folder.mkdir(exist_ok=True)
    if rooms:
        from pxr import Usd

        stage = Usd.Stage.CreateNew(str(folder / "scene.usda"))
        stage.DefinePrim("/World/Room")
        stage.Save()
        (folder / "report.json").write_text(json.dumps({"layout": {"rooms": list(rooms)}}))
    return score(capture, capture.runs[run], Outcome(folder, said, seconds))


def test_a_scan_is_also_run_on_its_side_and_in_millimetres(data):
    (capture,) = captures(data)
    assert [run.name for run in capture.runs] == ["plain", "nolabels", "on its side", "millimetres"]
    assert [run.change for run in capture.runs] == ["", "strip", "on its side", "millimetres"]
    assert Path(capture.runs[0].words[1]) == (data / "data/room/scan.ply").resolve()
    assert len(captures(data, derived=False)[0].runs) == 2
    assert captures(data, only=["other"]) == []


def test_totals_add_up(data):
    pytest.importorskip("fcl")
    from benchmarks.real.__main__ import totals, verdicts

    wide = found([[0, 0], [5, 0], [5, 3], [0, 3]], [hole(), hole(x=2.5)])
    rows = [row(data, 0, rooms=[found(openings=[hole()])]), row(data, 1, rooms=[wide])]
    figures = totals(captures(data), rows)
    assert figures["iou"] == pytest.approx(1)
    assert figures["plain_counts"] == "1/2/1"
    assert figures["calibration"] == pytest.approx((3 * 0.9 - 2) / 3)
    assert figures["wrong_axis"] == figures["tilted"] == figures["changed_in_silence"] == 0
    met = {name: ok for name, _, _, ok in verdicts(figures)}
    assert met["iou"] and met["plain_recall"] and not met["plain_precision"]
    assert met["category"] is None


def test_openings_of_a_run_count_once(data):
    pytest.importorskip("fcl")
    from benchmarks.real.__main__ import totals

    plain = row(data, 0, rooms=[found(openings=[hole()])])
    told = replace(plain, run=replace(plain.run, name="told"))
    assert totals(captures(data), [plain, told])["labelled_counts"] == "1/1/1"


def test_a_wrong_axis_in_silence_shows(data):
    from benchmarks.real.__main__ import totals

    (capture,) = captures(data)
    sideways = [replace(capture, truth=replace(capture.truth, up_axis="y"))]
    tilted = found()
    tilted["floor"]["normal"] = [0, 1, 0]
    silent = row(data, 0, rooms=[tilted])
    assert silent.tilted and silent.plan.iou == 0
    assert totals(sideways, [silent])["wrong_axis"] == 1
    (data / "out0" / "scene.usda").unlink()
    unhelpful = row(data, 0, said="error: too few points")
    assert totals(sideways, [unhelpful])["wrong_axis"] == 1
    helpful = row(data, 0, said="error: nothing is level\n  remedy: give --up")
    assert totals(sideways, [helpful])["wrong_axis"] == 0
    assert helpful.plan.openings.typed.true == 1


def test_a_wrong_unit_in_silence_shows(data):
    from benchmarks.real.__main__ import totals

    (capture,) = captures(data)
    small = [replace(capture, truth=replace(capture.truth, unit=0.001))]
    silent, named = (row(data, 0, said=f"error: {said}") for said in ("4 points", "unit: mm?"))
    assert totals(small, [silent])["wrong_unit"] == 1
    assert totals(small, [named])["wrong_unit"] == 0
    assert totals([capture], [silent])["wrong_unit"] == 0


def test_a_crash_is_no_refusal(data):
    said = "Traceback (most recent call last):\n  File x\nValueError: the unit --up\n"
    crashed = row(data, 0, said=said)
    assert crashed.refusal == "crashed: ValueError: the unit --up"
    assert not row(data, 2, said=said).honest and not row(data, 3, said=said).honest


def test_a_changed_scan_is_corrected_or_refused_with_the_remedy(data):
    from benchmarks.real.running import ON_ITS_SIDE

    lying = found()
    lying["corners"] = (np.array(lying["corners"]) @ ON_ITS_SIDE.T).tolist()
    lying["floor"]["normal"] = [0, 1, 0]
    assert row(data, 2, rooms=[lying]).honest
    assert not row(data, 2, rooms=[found()]).honest
    assert not row(data, 3, said="error: the scan has 4 points").honest
    assert row(data, 3, said="error: 4 points\n  remedy: is the unit mm?").honest


def test_what_is_absent_is_said(tmp_path):
    from benchmarks.real.__main__ import main

    done = CliRunner().invoke(main, ["--data", str(tmp_path)])
    assert done.exit_code == 0
    assert "skipped: there is no captures.json in" in done.output
    assert "no capture to run" in done.output


def test_sources_are_named_with_their_commits():
    from benchmarks.real.__main__ import main
    from benchmarks.real.captures import SOURCES

    listed = CliRunner().invoke(main, ["--fetch-list"]).output
    assert all(
        len(s.commit) == 40 and f"| {s.repository} | {s.commit} |" in listed for s in SOURCES
    )


@pytest.mark.long
@pytest.mark.slow
def test_a_real_capture_whole(real, tmp_path):
    folder = real("real_dev/captures.json").parent
    target = tmp_path / "real.json"
    words = ["--data", folder, "--only", "roomplan_kitchen", "--only", "rgbd_fragment"]
    command = [sys.executable, "-m", "benchmarks.real", *map(str, words), "--save", str(target)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rows = {(r["capture"], r["run"]["name"]): r for r in json.loads(target.read_text())["rows"]}
    assert set(rows) == {
        ("roomplan_kitchen", "json"),
        ("roomplan_kitchen", "usdz"),
        ("rgbd_fragment", "plain"),
        ("rgbd_fragment", "told"),
    }
    export = rows["roomplan_kitchen", "json"]["export"]
    assert export["equal"] and export["same"]["passages"]
    assert export["category"] == export["place"] == export["objects"] == 15
    assert rows["rgbd_fragment", "told"]["degrees"] < 3
    assert "| roomplan_kitchen | json |" in done.stdout
