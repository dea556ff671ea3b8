"""What cannot be made is told at once, with the line, before any step runs or within one."""

from pathlib import Path

import pytest

import openrooms_usd as ou
from openrooms_usd.composing import compose_room
from openrooms_usd.errors import DescriptionError
from openrooms_usd.steps.checks import checked

WRONG = """\
layout:
  partitions: [{line: [[9, 9], [10, 9]]}]
  openings:
    - {kind: door, wall: 0, at: 4.9}
    - {kind: window, wall: 1, width: 3}
    - {kind: window, wall: 1}
furniture:
  objects:
    - {category: bed, at: [2, 2], size: [140, 205, 95]}
    - {category: chair, at: [2, 2], style: slats}
    - {name: own, category: chair, at: [2, 2], file: bed.obj}
    - {category: chair, at: [2, 2], fronts: slab, style: slat}
    - {category: chiar, at: [2, 2]}
lights:
  environment: {file: sky.hdr}
  lamps: {own: {profile: my.ies}}
materials:
  floor: {file: tiles}
  annotations: {own: notes.txt}
"""
SAID = """\
2:23: layout.partitions[0].line: partition_0 does not lie inside the room
4:7: layout.openings[0]: door_0 in wall 0 reaches beyond the left end of the wall
6:7: layout.openings[2]: window_0 and window_1 in wall 1 overlap
9:41: furniture.objects[0].size: a bed of 140 x 205 x 95 m cannot be built
10:44: furniture.objects[1].style: no chair has the style 'slats' (did you mean 'slat'?)
11:54: furniture.objects[2].file: {folder}/bed.obj: no such file
12:45: furniture.objects[3].fronts: a chair of the style slat has no fronts to choose
13:18: furniture.objects[4].category: found 'chiar' (did you mean 'chair'?)
15:23: lights.environment.file: {folder}/sky.hdr: no such file
16:26: lights.lamps.own.profile: {folder}/my.ies: no such file
18:17: materials.floor.file: {folder}/tiles: no such file
19:22: materials.annotations.own: {folder}/notes.txt: no such file
"""


def mistakes(text: str, folder: Path) -> list[str]:
    file = folder / "room.yaml"
    file.write_text(text)
    with pytest.raises(DescriptionError) as refused:
        compose_room(file, folder / "out")
    assert not (folder / "out").exists() or not any((folder / "out").rglob("scene.usda"))
    return [row.strip().removeprefix(f"{file}:") for row in str(refused.value).splitlines()[1:]]


def test_all_that_cannot_be_made_is_told_at_once(tmp_path: Path) -> None:
    found = mistakes(WRONG, tmp_path)
    expected = SAID.replace("{folder}", str(tmp_path)).splitlines()
    assert [row[: len(start)] for row, start in zip(found, expected, strict=True)] == expected


def test_beside_what_is_no_valid_description_too(tmp_path: Path) -> None:
    """And without it, the same rows."""
    valid = mistakes(WRONG.replace("chiar", "chair"), tmp_path)
    assert valid == [row for row in mistakes(WRONG, tmp_path) if "chiar" not in row]


def test_from_python_the_path_alone_is_told(tmp_path: Path) -> None:
    room = ou.load_room({"furniture": {"objects": [{"category": "bed", "at": [1, 1]}]}})
    room.update(furniture={"objects": [{"category": "bed", "at": [1, 1], "size": [1, 30, 1]}]})
    with pytest.raises(DescriptionError, match=r"\n  furniture.objects\[0\].size: a bed of 1 x 30"):
        checked(room, tmp_path)


@pytest.mark.parametrize(
    ("section", "rows"),
    [
        (
            "materials:\n  overrides: {chair_0: {sead: wood}, stool_0: {all: wood, x: paint}}\n"
            "  accents: {wal_1: paint}\n",
            ["overrides.chair_0.sead", "overrides.stool_0.x", "accents.wal_1"],
        ),
        ("lights: {lamps: {chair_0: {}, stool_0: {}}}\n", ["lamps.chair_0", "lamps.stool_0"]),
        ("physics: {}\nlights: {screens: {chair_0: {}, stool_0: {}}}\n", ["chair_0", "stool_0"]),
    ],
)
def test_what_a_step_finds_has_its_line(section: str, rows: list[str], tmp_path: Path) -> None:
    text = "furniture:\n  objects: [{category: chair, at: [1, 1]}, {category: stool, at: [3, 1]}]\n"
    small = "materials: {resolution: 16}\n" if "materials" not in section else ""
    found = mistakes(text + small + section, tmp_path)
    assert len(found) == len(rows)
    for said, row in zip(found, rows, strict=True):
        place, path, _ = said.split(" ", 2)
        line = int(place.partition(":")[0])
        assert (
            path.endswith(f"{row}:")
            and row.rpartition(".")[2] in (text + small + section).splitlines()[line - 1]
        )
