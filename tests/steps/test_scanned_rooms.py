"""Which room of a scan is built: the choice is told, and a wrong number says what there is."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from openrooms_usd.capture import Capture
from openrooms_usd.composing import compose_room
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import FoundLayout
from openrooms_usd.scan.results import FoundRoom
from openrooms_usd.steps.layout import scanned
from tests.scan.scanned_rooms import RoomScan

HALL = ((0.0, 0.0), (4.0, 0.0), (4.0, 5.0), (0.0, 5.0))


def square(side: float) -> FoundRoom:
    corners = np.array([[0, 0, 0], [side, 0, 0], [side, side, 0], [0, side, 0]], float)
    return FoundRoom(np.array([0.0, 0, 1]), np.zeros(3), corners, ceiling=2.5)


LEVEL = SimpleNamespace(scan_from_level=np.eye(4), level_from_scan=np.eye(4), notes=())
FOUND = FoundLayout(LEVEL, Cloud(np.zeros((1, 3))), (square(5.0), square(3.0)))  # type: ignore[arg-type]


def take(room: int) -> scanned.ScannedRoom:
    layout = ScanLayout(**{"from": "scan", "scan": "scan.ply", "room": room})
    return scanned.taken(layout, Path("scan.ply"), FOUND, Capture("scan.ply", np.eye(4)))


def test_a_room_of_several_is_told_with_the_others() -> None:
    room = take(1)
    assert room.capture.floor is not None
    assert np.ptp(room.capture.floor, axis=0).tolist() == [3.0, 3.0]
    (note,) = [note for note in room.capture.notes if "rooms" in note]
    assert "0 (25.0 m2), 1 (9.0 m2); `room` selects" in note


def test_a_room_that_is_not_there_says_which_are() -> None:
    with pytest.raises(InputError, match="no room 7") as caught:
        take(7)
    assert "0 (25.0 m2), 1 (9.0 m2)" in caught.value.remedy


# Composes one step, and counts what is found and what of a scan is read meanwhile.
COUNTING = """
import sys
from pathlib import Path
from openrooms_usd import capture
from openrooms_usd.composing import compose_room
from openrooms_usd.scan import reconstruction
from openrooms_usd.steps.layout import scanned
from tests.scan.scanned_rooms import RoomScan

HALL = ((0.0, 0.0), (4.0, 0.0), (4.0, 5.0), (0.0, 5.0))
counted = []
for home, name in ((scanned, "find_rooms"), (scanned, "read_capture"), (capture, "read_capture")):
    def call(*arguments, made=getattr(home, name), name=name, **options):
        counted.append(name)
        return made(*arguments, **options)
    setattr(home, name, call)
done = compose_room(Path(sys.argv[1]), Path(sys.argv[2]), only=sys.argv[3] or None, workers=1)
print(*(row.stage for row in done.stages if row.state == "written"), *sorted(counted))
"""


@pytest.mark.slow
def test_what_the_layout_finds_is_not_found_again_by_another_process(tmp_path: Path) -> None:
    np.savez(tmp_path / "hall.npz", points=RoomScan(HALL).cloud().points)
    (tmp_path / "room.yaml").write_text(
        "layout: {from: scan, scan: hall.npz}\nfurniture: {from: scan, unlabelled: leave_out}\n"
    )

    def run(only: str, out: str = "out") -> list[str]:
        command = [sys.executable, "-c", COUNTING, "room.yaml", out, only]
        return subprocess.check_output(command, cwd=tmp_path, text=True).split()

    assert run("layout") == ["layout", "find_rooms", "read_capture"]
    assert run("alignment") == ["alignment"]
    assert run("layout") == []
    # As in one process, to the last byte, wherever it lies.
    assert run("", "deep/whole")[-2:] == ["find_rooms", "read_capture"]
    layers = [tmp_path / out / "layers" for out in ("out", "deep/whole")]
    [found] = [path.relative_to(layers[0]) for path in layers[0].rglob("found-*.npz")]
    for file in ("layout.usda", "alignment.usda", found):
        assert (layers[0] / file).read_bytes() == (layers[1] / file).read_bytes()
    assert str(tmp_path).encode() not in (layers[0] / found).read_bytes()

    # What somebody has changed is not believed, and what is missing is found again.
    (layers[0] / found).write_bytes((layers[0] / found).read_bytes()[:-7])
    (layers[0] / "alignment.usda").unlink()
    with pytest.raises(InputError, match=str(found)):
        compose_room(tmp_path / "room.yaml", tmp_path / "out", only="furniture")
    (layers[0] / found).unlink()
    assert run("layout") == ["layout", "find_rooms", "read_capture"]
