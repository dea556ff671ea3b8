"""The importer of plain scans: units, up, origins far away, and segments in a file beside."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from openrooms_usd.capture import read_capture
from openrooms_usd.errors import InputError
from openrooms_usd.importing import import_capture
from orusd_scans.plainscan import ScanImporter, direction, upright
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
        "7 points without finite coordinates were dropped",
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


COUNT = 600


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """Two cubes of points 2 m apart, as a PLY file."""
    rng = np.random.default_rng(3)
    points = rng.uniform(0, 0.3, (COUNT, 3))
    points[COUNT // 2 :, 0] += 2.0
    rows = "\n".join(" ".join(f"{value:.5f}" for value in row) for row in points)
    head = f"ply\nformat ascii 1.0\nelement vertex {COUNT}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    path = tmp_path / "scan.ply"
    path.write_text(f"{head}end_header\n{rows}\n")
    return path


def saved(path: Path, **arrays: NDArray[np.generic]) -> Path:
    np.savez_compressed(path, **arrays)  # type: ignore[arg-type]
    return path


def read(scan: Path, segments: Path):  # type: ignore[no-untyped-def]
    cloud = ScanImporter().read(scan, {"segments": str(segments), "unit": "m"}).cloud
    assert cloud is not None
    return cloud


def test_words_alone_make_a_thing_of_each_connected_part(scan: Path, tmp_path: Path) -> None:
    words = np.array(["Guitar"] * COUNT)
    for cloud in (
        read(scan, saved(tmp_path / "words.npz", label=words)),
        read(scan, saved(tmp_path / "bytes.npz", label=words.astype("S"))),
    ):
        assert cloud.words == {1: ("guitar",), 2: ("guitar",)}
        assert cloud.instance.tolist() == [1] * (COUNT // 2) + [2] * (COUNT // 2)
    np.save(tmp_path / "words.npy", words)
    assert read(scan, tmp_path / "words.npy").words == {1: ("guitar",), 2: ("guitar",)}


def test_numbers_are_classes_and_things(scan: Path, tmp_path: Path) -> None:
    instance = np.repeat([4, 0], COUNT // 2)
    label = np.repeat([7, 2], COUNT // 2)
    np.save(tmp_path / "both.npy", np.column_stack([label, instance]))
    for path in (
        saved(tmp_path / "both.npz", label=label.astype("f4"), instance=instance),
        tmp_path / "both.npy",
    ):
        cloud = read(scan, path)
        assert cloud.instance.tolist() == instance.tolist()
        assert cloud.label.tolist() == label.tolist()
    np.save(tmp_path / "things.npy", instance - 1)
    alone = read(scan, tmp_path / "things.npy")
    assert alone.label is None
    assert alone.instance.tolist() == np.repeat([3, 0], COUNT // 2).tolist()


@pytest.mark.parametrize(
    ("name", "arrays", "message"),
    [
        (
            "s.npz",
            {"label": np.zeros(5, "i4")},
            "'label' has 5 values, but the scan's file has 600 points",
        ),
        ("s.npz", {"instance": np.zeros((COUNT, 3), "i4")}, "has the shape 600 x 3"),
        ("s.npz", {"instance": np.full(COUNT, 0.5)}, "'instance' has fractions"),
        ("s.npz", {"instance": np.array(["a"] * COUNT)}, "'instance' holds words"),
        ("s.npz", {"instance": np.full(COUNT, 1 << 30)}, "beyond 16,777,216"),
        ("s.npz", {"label": np.full(COUNT, b"\xff")}, "a label is not text"),
        ("s.npz", {"masks": np.zeros(COUNT)}, "no array label or instance"),
        ("s.npz", {"label": np.array([{}] * COUNT)}, "no numbers or words but object"),
        ("s.csv", {}, "files that end in '.csv' are not supported segments"),
    ],
)
def test_what_does_not_fit_is_refused_with_the_remedy(
    scan: Path, tmp_path: Path, name: str, arrays: dict[str, NDArray[np.generic]], message: str
) -> None:
    path = tmp_path / name
    if arrays:
        saved(path, **arrays)
    else:
        path.write_text("1\n")
    with pytest.raises(InputError) as caught:
        read(scan, path)
    assert message in str(caught.value)
    assert caught.value.remedy


@pytest.mark.usefixtures("any_scan_will_do")
def test_the_file_comes_with_the_room(scan: Path, tmp_path: Path) -> None:
    segments = saved(tmp_path / "mine.npz", label=np.array(["sofa"] * COUNT))
    made = import_capture("scan", scan, tmp_path / "room", {"segments": str(segments), "unit": "m"})
    assert (tmp_path / "room" / "segments.npz").read_bytes() == segments.read_bytes()
    assert made.room.layout.asked["segments"] == "segments.npz"  # type: ignore[union-attr]
    assert not any("the scan has no labels" in note for note in made.notes)


@pytest.mark.usefixtures("any_scan_will_do")
def test_a_scan_that_says_nothing_is_told_so(scan: Path, tmp_path: Path) -> None:
    made = import_capture("scan", scan, tmp_path / "room", {"unit": "m"})
    assert any("the scan has no labels" in note for note in made.notes)
    assert "unlabelled: furnish" in made.file.read_text()
