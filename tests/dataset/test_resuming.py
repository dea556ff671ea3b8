"""Real rooms by the real command: killed at any moment, any number of workers, same bytes."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from openrooms_usd.dataset.status import status_of, verify
from openrooms_usd.rendering.reading import read_render
from tests.dataset.conftest import PATIENCE_S, Checksums, Made, Start, wait_for
from tests.disks import disk

pytestmark = pytest.mark.slow


def kill_when(process: subprocess.Popen[str], out: Path, pattern: str) -> None:
    """Kill a run as soon as something is there: it has no moment to tidy up."""
    wait_for(process, out, pattern)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()


def test_a_run_that_is_killed_ends_with_the_same_bytes(
    made: Made, tmp_path: Path, checksums: Checksums, start: Start
) -> None:
    file, undisturbed = made
    out = tmp_path / "out"
    # While a room is composed, and while a second view is written.
    for pattern in ("scenes/*/*/layers/*.usda", "renders/*/*/.view_1.*"):
        kill_when(start(file, out), out, pattern)
    finished = status_of(out).finished
    process = start(file, out, workers=2)
    said, wrong = process.communicate()
    assert process.returncode == 1, wrong
    assert json.loads(said)["kept"] == finished >= 1
    assert checksums(out).keys() == checksums(undisturbed).keys()
    assert {k for k, v in checksums(out).items() if checksums(undisturbed)[k] != v} == set()


def test_a_run_that_alone_is_told_to_stop_leaves_without_errors(
    source: Path, tmp_path: Path, start: Start
) -> None:
    """By ``kill -INT PID``, and once more: its workers hear nothing of it, and write to nobody."""
    out = tmp_path / "out"
    process = start(source, out, workers=2)
    wait_for(process, out, "scenes/*/*/layers/*.usda")
    process.send_signal(signal.SIGINT)
    time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    said, wrong = process.communicate()
    assert process.returncode == 130, wrong
    assert (said, wrong.strip()) == ("", "Interrupted. What was finished is kept.")


def test_a_clock_that_jumps_changes_nothing(
    made: Made, tmp_path: Path, checksums: Checksums, start: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a year, to and fro, with the real thing: libfaketime between the run and its clock."""
    if shutil.which("faketime") is None:
        pytest.skip("there is no faketime")
    words = ["faketime", "-f", "+0", "printenv", "LD_PRELOAD"]
    library = subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    file, undisturbed = made
    clock, out = tmp_path / "clock", tmp_path / "out"
    clock.write_text("-365d")
    with monkeypatch.context() as patch:
        patch.setenv("LD_PRELOAD", library)
        patch.setenv("FAKETIME_TIMESTAMP_FILE", str(clock))
        # What is asked anew each second; a clock of its own counts seconds as before.
        patch.setenv("FAKETIME_CACHE_DURATION", "1")
        patch.setenv("FAKETIME_DONT_FAKE_MONOTONIC", "1")
        patch.setenv("NO_FAKE_STAT", "1")
        told = subprocess.run(
            [sys.executable, "-c", "import time; print(time.time())"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        assert float(told) < time.time() - 300 * 86400
        process = start(file, out, 2)
    for pattern, jump in (("scenes/*/*/layers/*", "+365d"), ("records/*/*/view_0.json", "-365d")):
        wait_for(process, out, pattern)
        clock.write_text(jump)
    _, wrong = process.communicate(timeout=10 * PATIENCE_S)
    assert process.returncode == 1, wrong
    assert checksums(out) == checksums(undisturbed)


def test_a_poisoned_room_is_recorded_and_the_rest_is_there(made: Made) -> None:
    _, out = made
    found = status_of(out)
    assert (found.finished, found.left) == (4, 0)
    assert {failure.unit.partition("/")[0] for failure in found.failures} == {"room_poisoned"}
    assert all("did you mean 'chair'" in failure.reason for failure in found.failures)
    whole = verify(out)
    assert (whole.damages, whole.views) == ((), 4)


def test_variants_share_their_views_and_what_no_material_changes(made: Made) -> None:
    _, out = made
    main, other = (
        read_render(out / "renders" / "room_good" / name) for name in ("main", "mainDiffMat")
    )
    assert list(main.views) == list(other.views) == ["view_0", "view_1"]
    assert main.manifest.storage == "compact"
    for view, twin in zip(main.views.values(), other.views.values(), strict=True):
        assert (view.world_from_camera == twin.world_from_camera).all()
        for channel in ("depth", "instance"):
            assert (view.pixels[channel] == twin.pixels[channel]).all()
        assert (view.pixels["radiance"] != twin.pixels["radiance"]).any()


def test_a_full_disk_stops_nothing_for_good(
    made: Made, tmp_path: Path, checksums: Checksums, start: Start
) -> None:
    """A disk that has room for nothing, for a part, and at last for all."""
    file, undisturbed = made
    with disk(tmp_path / "disk", "size=64m") as small:
        out = small / "out"
        for spare_kib in (64, 300):
            room = shutil.disk_usage(small).free
            (small / "ballast").write_bytes(bytes(room - 1024 * spare_kib))
            said, wrong = start(file, out).communicate()
            assert "Traceback" not in said + wrong
            assert "No space left" in said + wrong
            (small / "ballast").unlink()
            assert not (out / "plan.jsonl").exists() or verify(out).damages == ()
        process = start(file, out)
        _, wrong = process.communicate()
        assert process.returncode == 1, wrong
        assert status_of(out).finished == 4
        assert checksums(out) == checksums(undisturbed)
