"""The importer of plain scans: units, up, origins far away, broken points."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.capture import read_capture
from openrooms_usd.errors import InputError
from orusd_scans.plainscan import direction, upright
from tests.scan.scanned_rooms import RoomScan

FURNITURE = (
    (0.3, 0.2, 1.6, 0.8, 0.0, 0.75),
    (2.2, 1.4, 0.9, 0.9, 0.0, 0.45),
    (4.3, 0.5, 0.6, 1.9, 0.0, 1.8),
    (0.2, 2.9, 2.0, 0.9, 0.0, 0.5),
)
CORNERS = ((0, 0), (5, 0), (5, 4), (0, 4))
DOOR = (0, 3, 4, 0, 2)
ROOM = RoomScan(CORNERS, boxes=FURNITURE, holes=[DOOR], spacing=0.05).cloud().points


def stored(path: Path, points: np.ndarray, **more: np.ndarray) -> Path:
    np.savez(path / "scan.npz", points=points, **more)
    return path / "scan.npz"


def test_metres_and_z_up_stay_as_they_are(tmp_path: Path) -> None:
    capture = read_capture("scan", stored(tmp_path, ROOM))
    assert (capture.cloud.points == ROOM).all()
    assert (capture.source_from_world == np.eye(4)).all()
    assert capture.notes == ()
    assert capture.floor is None
    assert "from: scan" in capture.remedy


@pytest.mark.one_in(3)
@pytest.mark.parametrize("unit", ["mm", "auto", "0.001"])
def test_millimetres(tmp_path: Path, unit: str) -> None:
    capture = read_capture("scan", stored(tmp_path, 1000 * ROOM), {"unit": unit})
    assert capture.cloud.points == pytest.approx(ROOM)
    assert ("millimetres are taken" in " ".join(capture.notes)) == (unit == "auto")
    assert capture.settled == ({"unit": "mm"} if unit == "auto" else {})
    back = capture.cloud.points @ capture.source_from_world[:3, :3].T
    assert back + capture.source_from_world[:3, 3] == pytest.approx(1000 * ROOM)


def test_coordinates_of_a_map_keep_their_digits(tmp_path: Path) -> None:
    far = np.array([651234.0, 5431234.0, 812.0])
    capture = read_capture("scan", stored(tmp_path, ROOM + far))
    assert np.abs(capture.cloud.points).max() < 10
    assert np.ptp(capture.cloud.points, axis=0) == pytest.approx(np.ptp(ROOM, axis=0), abs=1e-8)
    back = capture.cloud.points + capture.source_from_world[:3, 3]
    assert back == pytest.approx(ROOM + far, abs=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("up", ["y", "0,1,0", "0,-2,0.2", "0,0,-1", "1,1,1", "z"])
def test_up_becomes_z(tmp_path: Path, up: str) -> None:
    normals = np.tile(np.array([[0.0, 0.6, 0.8]], "f4"), (len(ROOM), 1))
    capture = read_capture("scan", stored(tmp_path, ROOM, normals=normals), {"up": up})
    axes = {"y": [0, 1, 0], "z": [0, 0, 1]}
    given = np.array(axes.get(up) or [float(w) for w in up.split(",")])
    world_from_source = np.linalg.inv(capture.source_from_world)[:3, :3]
    assert world_from_source @ given / np.linalg.norm(given) == pytest.approx([0, 0, 1])
    assert np.linalg.det(world_from_source) == pytest.approx(1.0)
    assert capture.cloud.points == pytest.approx(ROOM @ world_from_source.T)
    assert capture.cloud.normals[0] == pytest.approx(world_from_source @ [0, 0.6, 0.8], abs=1e-6)


def test_the_least_turn_is_taken() -> None:
    tilt = np.radians(5.0)
    turn = upright(direction(f"0,{np.sin(tilt)},{np.cos(tilt)}", Path("s")))
    assert np.degrees(np.arccos((np.trace(turn) - 1) / 2)) == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"unit": "ell"}, "unit 'ell' is not known"),
        ({"unit": "-1"}, "unit '-1' is not known"),
        ({"up": "0,0,0"}, "direction"),
        ({"up": "up"}, "direction"),
        ({"up": "0,0,nan"}, "direction"),
        ({"up": "1,2"}, "direction"),
        ({"color": "red"}, "no option 'color'"),
    ],
)
def test_options_that_mean_nothing_are_refused(tmp_path: Path, options: dict, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_capture("scan", stored(tmp_path, ROOM), options)


def test_broken_points_are_dropped_and_counted(tmp_path: Path) -> None:
    points = np.concatenate([ROOM, ROOM[:100], np.full((7, 3), np.nan)])
    capture = read_capture("scan", stored(tmp_path, points))
    assert len(capture.cloud) == len(ROOM)
    assert capture.notes == (
        "7 points without a finite place were dropped",
        "100 duplicated points were dropped",
    )
    with pytest.raises(InputError, match="no point has finite coordinates"):
        read_capture("scan", stored(tmp_path, np.full((7, 3), np.nan)))


def test_photographs_come_along_as_eyes(tmp_path: Path) -> None:
    pose = [[1, 0, 0, 2500], [0, 0, 1, 1000], [0, -1, 0, 1400], [0, 0, 0, 1]]
    frames = tmp_path / "frames.json"
    K = "[[500, 0, 320], [0, 500, 240], [0, 0, 1]]"
    frames.write_text(
        f'[{{"id": "7", "resolution": [640, 480], "K": {K}, "world_from_camera": {pose}}}]'
    )
    options = {"frames": str(frames), "unit": "mm"}
    capture = read_capture("scan", stored(tmp_path, 1000 * ROOM), options)
    assert [frame.id for frame in capture.frames] == ["7"]
    assert capture.cloud.sensor_origins == pytest.approx(np.array([[2.5, 1.0, 1.4]]))


def test_unknown_endings_name_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'\.docx'") as caught:
        read_capture("scan", tmp_path / "a.docx")
    assert ".ply" in caught.value.remedy


def test_where_points_were_seen_from(tmp_path: Path) -> None:
    points, sensor_origins = np.eye(3) * 1000.0, np.array([[0, 0, 1500.0], [np.nan, 0, 0]])
    for name in ("sensor_origins", "eyes"):
        np.savez(tmp_path / f"{name}.npz", points=points, **{name: sensor_origins})
        cloud = read_capture("scan", tmp_path / f"{name}.npz", {"unit": "mm"}).cloud
        np.testing.assert_allclose(cloud.sensor_origins, [[0, 0, 1.5]])
    np.savez(tmp_path / "bad.npz", points=points, sensor_origins=sensor_origins[:, :2])
    with pytest.raises(InputError, match="'sensor_origins' has the shape"):
        read_capture("scan", tmp_path / "bad.npz")
