"""Which room of a scan is built: the choice is told, and a wrong number says what there is."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from openrooms_usd.capture import Capture
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import FoundLayout
from openrooms_usd.scan.results import FoundRoom
from openrooms_usd.stages import scanned


def square(side: float) -> FoundRoom:
    corners = np.array([[0, 0, 0], [side, 0, 0], [side, side, 0], [0, side, 0]], float)
    return FoundRoom(np.array([0.0, 0, 1]), np.zeros(3), corners, ceiling=2.5)


@pytest.fixture
def two_rooms(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    (tmp_path / "scan.ply").write_bytes(b"ply")
    level = SimpleNamespace(scan_from_level=np.eye(4), notes=())
    found = FoundLayout(level, Cloud(np.zeros((1, 3))), (square(5.0), square(3.0)))  # type: ignore[arg-type]
    capture = Capture("scan.ply", np.eye(4))
    monkeypatch.setattr(scanned, "_found", lambda *_, **__: (found, capture))
    monkeypatch.setattr(scanned, "capture_path", lambda *_: tmp_path / "scan.ply")
    return SimpleNamespace(source=tmp_path)


def layout(room: int) -> ScanLayout:
    return ScanLayout(**{"from": "scan", "scan": "scan.ply", "room": room})


def test_a_room_of_several_is_told_with_the_others(two_rooms: SimpleNamespace) -> None:
    room = scanned.scanned_room(two_rooms, layout(1))  # type: ignore[arg-type]
    assert room.capture.floor is not None
    assert np.ptp(room.capture.floor, axis=0).tolist() == [3.0, 3.0]
    (note,) = [note for note in room.capture.notes if "rooms" in note]
    assert "0 (25.0 m2), 1 (9.0 m2); `room` takes" in note


def test_a_room_that_is_not_there_says_which_are(two_rooms: SimpleNamespace) -> None:
    with pytest.raises(InputError, match="no room 7") as caught:
        scanned.scanned_room(two_rooms, layout(7))  # type: ignore[arg-type]
    assert "0 (25.0 m2), 1 (9.0 m2)" in caught.value.remedy
