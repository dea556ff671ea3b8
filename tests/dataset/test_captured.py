"""Rooms of scans: those that show enough are composed, the others left out with the reason."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.dataset.plan import capture_digest, plan_jobs
from openrooms_usd.dataset.records import LEFT_OUT
from openrooms_usd.dataset.status import status_of
from openrooms_usd.dataset.store import Store
from openrooms_usd.dataset.variants import LeftOutError, captured_room, coverage_of
from openrooms_usd.description import load_dataset, load_room
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.errors import DescriptionError, InputError

TEXT = """\
name: scans
rooms:
  - {from: captures, files: [room.npz], coverage: COVERAGE}
views: {count: 1, resolution: [16, 12]}
channels: [depth]
rendering: {renderer: preview}
"""


def box(keep: float = 1.0) -> np.ndarray:
    """Points on the floor, the ceiling and the walls of a room, of which so much is kept."""
    rng = np.random.default_rng(1)
    points = rng.uniform([0, 0, 0], [4.2, 3.1, 2.6], (60_000, 3))
    side = rng.integers(0, 6, len(points))
    for number in range(6):
        axis, end = divmod(number, 2)
        points[side == number, axis] = (0.0, (4.2, 3.1, 2.6)[axis])[end]
    return points[points[:, 0] <= 4.2 * keep]


def dataset(folder: Path, coverage: float, keep: float = 1.0) -> Path:
    np.savez(folder / "room.npz", points=box(keep).astype(np.float32))
    (folder / "dataset.yaml").write_text(TEXT.replace("COVERAGE", str(coverage)))
    return folder / "dataset.yaml"


def test_a_whole_scan_is_taken_where_it_lies(tmp_path: Path) -> None:
    file = dataset(tmp_path, 0.9)
    (job,) = plan_jobs(load_dataset(file))
    room = captured_room(job, tmp_path)
    assert isinstance(room.layout, ScanLayout) and room.layout.file == "room.npz"
    found = coverage_of(job, room, tmp_path, tmp_path / "scene")
    assert found is not None and min(found.values()) > 0.97
    assert {path.name for path in tmp_path.iterdir()} == {"dataset.yaml", "room.npz", "scene"}


def test_a_scan_that_shows_little_is_left_out_with_its_reason(tmp_path: Path) -> None:
    dataset(tmp_path, 0.9, keep=0.6)
    (job,) = plan_jobs(load_dataset(tmp_path / "dataset.yaml"))
    room = captured_room(job, tmp_path)
    with pytest.raises(LeftOutError, match=r"of the floor and .* of the walls|too little"):
        coverage_of(job, room, tmp_path, tmp_path / "scene")


def test_a_scan_that_cannot_be_read_has_failed_and_is_not_left_out(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text("layout: {from: scan, scan: nowhere.ply}\n")
    text = TEXT.replace("from: captures, files: [room.npz]", "files: [room.yaml]")
    (tmp_path / "dataset.yaml").write_text(text.replace("COVERAGE", "0.5"))
    (job,) = plan_jobs(load_dataset(tmp_path / "dataset.yaml"))
    with pytest.raises(DescriptionError, match="no such file") as refused:
        coverage_of(job, load_room(tmp_path / "room.yaml"), tmp_path, tmp_path / "scene")
    assert not isinstance(refused.value, LeftOutError)


def test_a_capture_of_another_kind_is_told_its_importer(tmp_path: Path) -> None:
    dataset(tmp_path, 0.5)
    (tmp_path / "room.npz").write_bytes(b"PK")
    (tmp_path / "room.npz").rename(tmp_path / "room.usdz")
    text = TEXT.replace("room.npz", "room.usdz").replace("COVERAGE", "0.5")
    (tmp_path / "dataset.yaml").write_text(text)
    (job,) = plan_jobs(load_dataset(tmp_path / "dataset.yaml"))
    with pytest.raises(InputError) as refused:
        captured_room(job, tmp_path)
    assert "orusd import roomplan" in str(refused.value)


def test_options_are_looked_up_as_files_where_they_could_be_some(tmp_path: Path) -> None:
    dataset(tmp_path, 0.5)
    plain = capture_digest(tmp_path, "room.npz", {})
    assert capture_digest(tmp_path, "room.npz", {"up": "z" * 300, "unit": "m"}) == plain
    (tmp_path / "frames.json").write_text("[]")
    assert capture_digest(tmp_path, "room.npz", {"frames": "frames.json"}) != plain
    with pytest.raises(InputError, match="longer than"):
        capture_digest(tmp_path, "a" * 300, {})


@pytest.mark.slow
def test_what_is_left_out_has_not_failed_and_is_not_tried_again(tmp_path: Path) -> None:
    from openrooms_usd.dataset.run import run_dataset

    file = dataset(tmp_path, 1.0, keep=0.97)
    done = run_dataset(file, tmp_path / "out")
    assert (done.made, done.failed) == (0, {})
    found = status_of(tmp_path / "out")
    assert (found.finished, found.left, found.failures) == (0, 0, ())
    assert "100% are required" in found.left_out["room_room"]
    store = Store(tmp_path / "out")
    (job,) = store.jobs()
    before = store.failure(job, 0)
    assert before is not None and before["code"] == LEFT_OUT
    run_dataset(file, tmp_path / "out")
    assert store.failure(job, 0) == before
    # Who asks for less has it made.
    dataset(tmp_path, 0.5)
    shutil.rmtree(tmp_path / "out" / "failures")
    assert run_dataset(file, tmp_path / "out").made == 1
    (job,) = store.jobs()
    shared = store.scene_record(job)
    assert shared is not None and shared["coverage"]["whole"] > 0.9


def frame(number: int, eye: tuple[float, float, float]) -> dict[str, object]:
    """A photograph that looks along x, level, with pixels of a width of its own."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]], eye
    K = [[60, 0, 33], [0, 60, 23], [0, 0, 1]]
    name = f"{number}.jpg"
    return {
        "id": str(number),
        "picture": name,
        "resolution": [64, 48],
        "K": K,
        "world_from_camera": pose.tolist(),
    }


@pytest.mark.slow
def test_views_are_those_of_photographs_evenly_spread(tmp_path: Path) -> None:
    from openrooms_usd.dataset.run import run_dataset

    file = dataset(tmp_path, 0.5)
    # As they were taken, which is not how their names are sorted; one of them was in the wall.
    frames = [frame(9 - n, (0.8 + 0.2 * n, 1.5, 1.2)) for n in range(7)]
    frames[3] = frame(6, (4.19, 1.5, 1.2))
    (tmp_path / "frames.json").write_text(json.dumps(frames))
    text = file.read_text().replace("coverage: 0.5", "options: {frames: frames.json}")
    text = text.replace("{count: 1, resolution", "{from: capture, count: 3, replace: 2, resolution")
    file.write_text(text)
    assert run_dataset(file, tmp_path / "out").made == 3
    store = Store(tmp_path / "out")
    (job,) = store.jobs()
    records = [store.record(job, number) for number in range(3)]
    # 9, 6 and 3 are asked for; of those between, the first and the last are spare.
    entries = [record["entry"] for record in records if record]
    assert [entry["photograph"]["id"] for entry in entries] == ["9", "8", "3"]
    assert records[1]["rejected"][0]["camera"].endswith("frame_6")
    for entry in entries:
        # A quarter of the photograph's size.
        np.testing.assert_allclose(entry["K"], [[15, 0, 8.25], [0, 15, 5.75], [0, 0, 1]])
