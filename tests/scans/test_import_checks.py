"""What `orusd import` refuses or notes before compose would."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.capture import read_capture
from openrooms_usd.errors import InputError
from openrooms_usd.importing import import_capture
from openrooms_usd.importing.checks import check_scan
from openrooms_usd.scan.rooms.levelling import level
from tests.scan.scanned_rooms import RoomScan

CORNERS = ((0, 0), (5, 0), (5, 4), (0, 4))
THINGS = ((0.3, 0.2, 1.6, 0.8, 0.0, 0.75), (2.2, 1.4, 0.9, 0.9, 0.0, 0.45))


def stored(path: Path, points: np.ndarray) -> Path:
    np.savez(path / "scan.npz", points=points)
    return path / "scan.npz"


def test_few_points_are_refused_in_the_words_of_compose(tmp_path: Path) -> None:
    points = RoomScan(CORNERS).cloud().points
    file = stored(tmp_path, points[:: len(points) // 36][:36])
    with pytest.raises(InputError) as composed:
        level(read_capture("scan", file).cloud)
    with pytest.raises(InputError, match="the scan has 36 points") as imported:
        import_capture("scan", file, tmp_path / "out")
    assert imported.value.message == composed.value.message
    assert imported.value.remedy == composed.value.remedy
    assert not (tmp_path / "out").exists()


def test_what_shows_little_of_its_room_needs_partial(tmp_path: Path) -> None:
    one_wall = RoomScan(CORNERS, boxes=THINGS, missing=(1, 2, 3), ceiling=False)
    said = check_scan(read_capture("scan", stored(tmp_path, one_wall.cloud().points)), tmp_path)
    assert "partial: true" in said
    assert "--up" in said


def test_a_whole_room_passes(tmp_path: Path) -> None:
    points = RoomScan(CORNERS, boxes=THINGS).cloud().points
    assert check_scan(read_capture("scan", stored(tmp_path, points)), tmp_path) == ""


@pytest.mark.parametrize("kind", ["roomplan", "sunrgbd", "scannet"])
def test_a_cloud_given_to_another_importer_names_the_right_one(tmp_path: Path, kind: str) -> None:
    (tmp_path / "scan.ply").write_bytes(b"ply\n\xff\xfe")
    with pytest.raises(InputError) as caught:
        import_capture(kind, tmp_path / "scan.ply", tmp_path / "out")
    assert "`orusd import scan`" in caught.value.remedy


@pytest.mark.parametrize("kind", ["roomplan", "scan", "scannet"])
def test_a_zipped_folder_shall_be_unzipped(tmp_path: Path, kind: str) -> None:
    (tmp_path / "scene.zip").write_bytes(b"PK\3\4")
    with pytest.raises(InputError) as caught:
        import_capture(kind, tmp_path / "scene.zip", tmp_path / "out")
    assert "unzip it" in caught.value.remedy


@pytest.mark.parametrize(
    ("kind", "inside", "said"),
    [
        ("scan", "scene_vh_clean_2.ply", "`orusd import scannet`, which reads such folders"),
        ("roomplan", "My room.usdz", "My room.usdz'`"),
        ("roomplan", "lounge.obj", "`orusd import scan "),
        ("scan", "lounge.obj", "`orusd import scan "),
    ],
)
def test_a_folder_names_its_importer_or_a_file_in_it(
    tmp_path: Path, kind: str, inside: str, said: str
) -> None:
    folder = tmp_path / "capture"
    folder.mkdir()
    (folder / inside).write_bytes(b"")
    with pytest.raises(InputError, match="this is a folder") as caught:
        import_capture(kind, folder, tmp_path / "out")
    assert said in caught.value.remedy


def test_a_folder_of_nothing_known_gets_no_hint(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="this is a folder") as caught:
        import_capture("scan", tmp_path, tmp_path / "out")
    assert caught.value.remedy == "give the file of the scan in it"
