import json
from pathlib import Path

import numpy as np
import pytest
import shapely

from openrooms_usd.capture import Capture
from openrooms_usd.description import load_room, parse_room
from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.importing.text import describe
from tests.commands import run

# Four walls of 4 x 3 m from the first principles of the format: column-major, Y up.
WALLS = [
    ([2, 1.2, 0], [1, 0, 0], 4),
    ([4, 1.2, -1.5], [0, 0, -1], 3),
    ([2, 1.2, -3], [-1, 0, 0], 4),
    ([0, 1.2, -1.5], [0, 0, 1], 3),
]


def surface(center: list, along: list, length: float, height: float = 2.4) -> dict:
    x, _, z = along
    return {
        "dimensions": [length, height, 0],
        "transform": [x, 0, z, 0, 0, 1, 0, 0, -z, 0, x, 0, *center, 1],
    }


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    data = {
        "walls": [surface(*wall) for wall in WALLS],
        "windows": [surface([2, 1.5, 0], [1, 0, 0], 1.2, 1.2)],
        "doors": [surface([4, 1.0, -1.5], [0, 0, -1], 0.9, 2.0)],
    }
    path = tmp_path / "my scan: #1.json"
    path.write_text(json.dumps(data))
    return path


def test_import_copies_the_capture_and_describes_the_room(capture: Path, tmp_path: Path) -> None:
    result = run("import", "roomplan", capture, "-o", tmp_path / "room", "--json")
    assert result.exit_code == 0, result.output
    report = json.loads(result.output)
    assert (report["walls"], report["openings"], report["objects"]) == (4, 2, 0)
    copy = tmp_path / "room" / capture.name
    assert copy.read_bytes() == capture.read_bytes()
    room = load_room(tmp_path / "room" / "room.yaml")
    assert room.layout.file == room.furniture.file == capture.name
    lamp = room.furniture.objects[0]
    assert lamp.category == "ceiling_lamp"
    assert lamp.at == (2.0, 1.5)
    assert room.cameras.views[0].count == 3


def test_the_lamp_of_a_concave_room_hangs_inside() -> None:
    floor = np.array([[0, 0], [6, 0], [6, 1], [1, 1], [1, 6], [0, 6]], dtype=float)
    text = describe("roomplan", Capture("a.json", np.eye(4), floor), "a.json")
    x, y = parse_room(text).furniture.objects[0].at
    assert shapely.Polygon(floor).buffer(-0.3).contains(shapely.Point(x, y))


def test_people_read_what_was_found(capture: Path, tmp_path: Path) -> None:
    result = run("import", "roomplan", capture, "-o", tmp_path / "room")
    assert "walls     4" in result.output
    assert "orusd compose" in result.output
    text = (tmp_path / "room" / "room.yaml").read_text()
    assert "# Captured" in text
    assert "1 door, 1 window" in text


@pytest.mark.parametrize(
    ("word", "type_"),
    [
        ("diningRoom", "dining_room"),
        ("Living Room", "living_room"),
        ("unidentified", "misc"),
        (None, "misc"),
        ("x: [", "misc"),
    ],
)
def test_the_source_says_what_a_room_is_for(word: str | None, type_: str) -> None:
    floor = np.array([[0, 0], [4, 0], [4, 3], [0, 3]], dtype=float)
    text = describe("roomplan", Capture("a.json", np.eye(4), floor, use=word), "a.json")
    assert parse_room(text).room == type_


def test_of_a_scan_people_read_its_size_and_what_points_have(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    walls = rng.random((40_000, 3)) * (4.0, 3.0, 2.5)
    side = rng.integers(0, 6, len(walls))
    for number in range(6):
        walls[side == number, number // 2] = (number % 2) * (4.0, 3.0, 2.5)[number // 2]
    np.savez(tmp_path / "scan.npz", points=walls, colors=np.zeros((len(walls), 3), "u1"))
    result = run("import", "scan", tmp_path / "scan.npz", "-o", tmp_path / "room")
    assert "walls " not in result.output and "objects " not in result.output
    assert "points    40000" in result.output
    assert "size      4.0 x 3.0 x 2.5 m" in result.output
    assert "each has  colors" in result.output
    assert "which finds walls, openings and furniture" in result.output


def test_a_room_that_is_there_is_not_overwritten(capture: Path, tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text("name: mine\n")
    result = run("import", "roomplan", capture, "-o", tmp_path)
    assert isinstance(result.exception, OutputError)
    assert (tmp_path / "room.yaml").read_text() == "name: mine\n"


def test_another_capture_of_that_name_is_not_overwritten(capture: Path, tmp_path: Path) -> None:
    (tmp_path / "room").mkdir()
    other = tmp_path / "room" / capture.name
    other.write_text("{}")
    result = run("import", "roomplan", capture, "-o", tmp_path / "room")
    assert isinstance(result.exception, OutputError)
    assert other.read_text() == "{}"
    assert sorted(p.name for p in other.parent.iterdir()) == [capture.name]


def test_the_folder_of_the_capture_may_be_the_output(capture: Path) -> None:
    assert run("import", "roomplan", capture, "-o", capture.parent).exit_code == 0
    assert load_room(capture.parent / "room.yaml").layout.file == capture.name


def test_a_capture_that_may_not_be_read_is_named(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*given: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("openrooms_usd.untrusted.os.open", refuse)
    result = run("import", "roomplan", capture, "-o", tmp_path / "room")
    assert isinstance(result.exception, InputError)
    assert str(capture) in str(result.exception)
    assert not (tmp_path / "room").exists()


def test_nothing_is_left_when_writing_fails(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(target: Path, text: str) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("openrooms_usd.importing.captures.write_text", full)
    before = sorted(tmp_path.iterdir())
    result = run("import", "roomplan", capture, "-o", tmp_path / "room")
    assert isinstance(result.exception, OutputError)
    assert sorted(tmp_path.iterdir()) == before


def test_the_importers_are_listed_and_unknown_ones_refused(tmp_path: Path) -> None:
    assert "roomplan" in run("import", "--help").output
    refused = run("import", "polycam", "a", "-o", tmp_path).exception
    assert isinstance(refused, InputError)
    assert "roomplan" in str(refused)
