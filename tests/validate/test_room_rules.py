"""What a room shows that nobody meant is found, named once and told; what is meant is not."""

from pathlib import Path

import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.demo import copy_example
from openrooms_usd.description import parse_room
from openrooms_usd.rules import validate_stage
from openrooms_usd.validation.room_rules import ROOM_RULES

CODES = {rule.code for rule in ROOM_RULES}
# An L-shaped room with a wall that stands free, a table with a chair under it, and a lamp.
ROOM = """
layout:
  polygon: [[0, 0], [6, 0], [6, 3], [3, 3], [3, 5], [0, 5]]
  partitions: [{name: screen, line: [[4.5, 0.3], [4.5, 1.5]]}]
{openings}
furniture:
  objects:
    - {name: table, category: table, at: [1.5, 1.5], size: [1.4, 0.9, 0.75]}
    - {name: chair, category: chair, at: [1.5, 0.95], yaw: 180}
    - {category: rug, at: [1.5, 1.5], size: [2, 1.5, 0.01]}
{objects}
materials: {resolution: 16}
lights:
  environment: {from: constant, illuminance: 10000}
cameras:
  resolution: [64, 48]
  views: [{name: view, eye: [{camera}], target: [1.5, 1.4, 0.5]}]
"""
LAMP = "    - {category: ceiling_lamp, at: [1.5, 2.5]}\n"
WINDOW = "  openings: [{kind: window, wall: 0}]"


def found(
    folder: Path, objects: str = LAMP, openings: str = "", camera: str = "0.5, 4.5, 1.5"
) -> tuple[list[tuple[str, str]], tuple[str, ...]]:
    """The rules that a room breaks with the prims' names, and what composing says."""
    text = ROOM.replace("{objects}", objects.rstrip()).replace("{openings}", openings)
    room = parse_room(text.replace("{camera}", camera))
    made = compose_room(room, folder)
    findings = [one for one in validate_stage(made.scene) if one.code in CODES]
    assert all(one.severity == "warning" for one in findings)
    return [(one.code, one.place.rpartition("/")[2]) for one in findings], made.notes


def test_a_sound_room_breaks_none(tmp_path: Path) -> None:
    assert found(tmp_path) == ([], ())


# Each stands where no other is wrong.
WRONG = {
    "far": ("outside-room", "{category: chair, at: [4.5, 4]"),
    "half": ("outside-room", "{category: chair, at: [3.2, 3.2]"),
    "deep": ("outside-room", "{category: chair, at: [5.5, 1, -0.3]"),
    "sofa": ("overlap", "{category: sofa, at: [1.5, 1.5]"),
    "walled": ("overlap", "{category: cabinet, at: [4.5, 0.9]"),
    "toy": ("size", "{category: chair, at: [5, 2.2], size: [0.2, 0.2, 0.2]"),
    "high": ("floating", "{category: chair, at: [0.5, 0.5, 0.8]"),
    "lost": ("floating", "{category: laptop, at: [2.7, 0.5], on: table"),
    "hung": ("floating", "{category: ceiling_lamp, at: [5, 2.2, 1]"),
    "huge": ("size", "{category: chair, at: [1.5, 4], size: [2, 1.2, 2.5]"),
}


def test_what_is_wrong_is_named(tmp_path: Path) -> None:
    objects = "".join(f"    - {what}, name: {name}}}\n" for name, (_, what) in WRONG.items())
    rows, notes = found(tmp_path, LAMP + objects)
    # The sofa lies in the chair, too.
    assert set(rows) == {(code, name) for name, (code, _) in WRONG.items()} | {("overlap", "chair")}
    assert len(rows) == len(set(rows)) and len(notes) == 4
    assert all("orusd validate" in note for note in notes)
    assert all(f"{name} " in " ".join(notes) for name in WRONG)


def test_what_stands_lies_hangs_or_is_stacked_is_carried(tmp_path: Path) -> None:
    """On a desk, on what lies there, in a shelf, at a wall, at the ceiling, on a sill."""
    carried = """
    - {name: desk, category: desk, at: [4, 2.5], size: [1.2, 0.6, 0.74]}
    - {name: book, category: book, at: [4, 2.5], size: [0.2, 0.15, 0.05], on: desk}
    - {category: mug, at: [4, 2.5], on: book}
    - {name: shelf, category: bookshelf, at: [0.2, 4], yaw: 90, size: [0.8, 0.3, 1.8]}
    - {category: picture, at: [0, 2], on: wall}
    - {category: picture, at: [4.45, 1], on: wall}
    - {category: curtain, at: [3, 0], on: wall}
    - {category: mug, at: [3, -0.06, 0.925], on: floor}
"""
    rows, _ = found(tmp_path, LAMP + carried.lstrip("\n"), WINDOW)
    assert [row for row in rows if row[0] == "floating"] == []


def test_sizes_that_are_slips_of_the_unit_are_named(tmp_path: Path) -> None:
    text = (
        "layout: {polygon: [[0, 0], [100, 0], [100, 4], [0, 4]], openings: [{kind: door, wall: 0, "
    )
    made = compose_room(
        parse_room(text + "width: 2 cm}]}\nmaterials: {resolution: 16}\n"), tmp_path
    )
    rows = [
        (f.place.rpartition("/")[2], f.message)
        for f in validate_stage(made.scene)
        if f.code == "unit"
    ]
    assert [name for name, _ in rows] == ["Room", "door_0"]
    assert "100 m long" in rows[0][1] and "0.02 m wide" in rows[1][1]


@pytest.mark.parametrize("place", ["8, 1, 1.5", "3.5, 3.5, 1.5", "1, 1, 2.9"])
def test_a_camera_outside_is_named(tmp_path: Path, place: str) -> None:
    assert found(tmp_path, camera=place)[0] == [("outside-room", "view")]


def test_a_camera_in_a_thing_is_named_and_one_under_a_table_is_not(tmp_path: Path) -> None:
    inside = f"{LAMP}    - {{category: box, at: [0.6, 3], size: [0.8, 0.8, 0.8]}}\n"
    assert found(tmp_path / "in", inside, camera="0.6, 3, 0.5")[0] == [("camera-inside", "view")]
    assert found(tmp_path / "under", camera="1.5, 1.7, 0.4")[0] == []


def test_a_room_without_lamp_and_opening_is_dark(tmp_path: Path) -> None:
    rows, notes = found(tmp_path / "dark", "")
    assert rows == [("light", "Room")]
    assert "no lamp shines" in notes[0]
    assert found(tmp_path / "window", "", WINDOW) == ([], ())


def test_strict_makes_errors_of_them(tmp_path: Path) -> None:
    found(tmp_path, "")
    findings = validate_stage(tmp_path / "scene.usda", strict=True)
    assert [one.severity for one in findings if one.code == "light"] == ["error"]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["bedroom", "kitchen", "office"])
def test_generated_rooms_break_none(tmp_path: Path, kind: str) -> None:
    room = parse_room(f"layout: {{from: generate}}\nfurniture: {{from: generate}}\nroom: {kind}\n")
    assert compose_room(room, tmp_path).notes == ()


@pytest.mark.slow
def test_the_example_breaks_none(tmp_path: Path) -> None:
    scene = compose_room(copy_example(tmp_path), tmp_path / "out").scene
    assert not CODES.intersection(one.code for one in validate_stage(scene))


def test_things_on_sills_are_in_the_room_and_those_in_the_wall_are_not(tmp_path: Path) -> None:
    mug = "    - {{name: {}, category: mug, at: [{}, -0.06, 0.925], on: floor}}\n"
    on_sill, walled = mug.format("on_sill", 3), mug.format("walled", 5)
    rows, _ = found(tmp_path, LAMP + on_sill + walled, WINDOW)
    assert rows == [("outside-room", "walled")]
