"""Real rooms by the real command: killed at any moment, any number of workers, same bytes."""

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from openrooms_usd.dataset.status import status_of
from openrooms_usd.dataset.verify import verify
from openrooms_usd.render.reading import read_render

pytestmark = pytest.mark.slow

_PATIENCE_S = 60.0

Checksums = Callable[[Path], dict[str, str]]
Start = Callable[..., subprocess.Popen[str]]


def kill_when(process: subprocess.Popen[str], out: Path, pattern: str) -> None:
    """Kill a run as soon as something is there: it has no moment to tidy up."""
    deadline = time.monotonic() + _PATIENCE_S
    while not any(out.glob(pattern)):
        assert process.poll() is None and time.monotonic() < deadline, pattern
        time.sleep(0.002)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()


def test_a_run_that_is_killed_ends_with_the_same_bytes(
    made: tuple[Path, Path], tmp_path: Path, checksums: Checksums, start: Start
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


def test_a_poisoned_room_is_recorded_and_the_rest_is_there(made: tuple[Path, Path]) -> None:
    _, out = made
    found = status_of(out)
    assert (found.finished, found.left) == (4, 0)
    assert {failure.unit.partition("/")[0] for failure in found.failures} == {"room_poisoned"}
    assert all("did you mean 'chair'" in failure.reason for failure in found.failures)
    whole = verify(out)
    assert (whole.damages, whole.views) == ((), 4)


def test_variants_share_their_views_and_what_no_material_changes(
    made: tuple[Path, Path],
) -> None:
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
