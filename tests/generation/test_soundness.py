"""Generated rooms hold together on their meshes, and the check finds what does not."""

from pathlib import Path

import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.description import parse_room
from openrooms_usd.furniture import category
from openrooms_usd.generation import generate, write
from openrooms_usd.generation.programs import PROGRAMS
from openrooms_usd.generation.shapes import Shapes
from tests.generation import checks, scenes
from tests.generation.assembled import assembled

# A door in the east, a table with a jar on it, a sofa before the north wall, a picture above it.
PLAIN = """\
layout:
  polygon: [[0, 0], [5, 0], [5, 4], [0, 4]]
  openings:
    - {{kind: door, wall: 1, at: 2, hinge: {hinge}, open: {open}}}
    - {{kind: door, wall: 3, at: 2}}
furniture:
  objects:
    - {{name: sofa, category: sofa, at: [{sofa}], size: [2, 0.9, 0.8], style: modern}}
    - {{name: table, category: table, at: [{table}], size: [1, 0.8, 0.74], style: four_legs}}
    - {{name: jar, category: jar, at: [{jar}], on: table}}
    - {{name: picture, category: picture, at: [2, 3.9, 1.4], on: wall}}
    - {{name: lamp, category: ceiling_lamp, at: [1, 1]}}
    - {{name: shelf, category: bookshelf, at: [{shelf}], size: [0.8, 0.3, 1.9]}}
"""
GOOD = {
    "sofa": "2, 3.54",
    "table": "2, 2.5",
    "jar": "2, 2.5",
    "shelf": "0.7, 0.16",
    "hinge": "left",
    "open": "0",
}
PLANTED = {
    "sofa in the wall": ({"sofa": "2, 3.58"}, "sofa penetrates wall_2"),
    "sofa outside": ({"sofa": "2, 3.58"}, "sofa is 30 mm outside"),
    "sofa in the shelf": ({"shelf": "3.37, 3.5"}, "sofa penetrates shelf"),
    "jar over the edge": ({"jar": "2.48, 2.5"}, "jar stands over the edge of table"),
    "jar in the air": ({"jar": "2, 2.5, 0.76"}, "jar does not touch table"),
    "jar in the table": ({"jar": "2, 2.5, 0.72"}, "table penetrates jar"),
    "shelf before the door": ({"shelf": "4.5, 2"}, "shelf stands before door_0"),
    "shelf in the swing": ({"shelf": "4.3, 1.7"}, "door_0 meets shelf"),
    "shelf in the other swing": ({"shelf": "4.3, 2.3", "hinge": "right"}, "door_0 meets shelf"),
    "shelf in an open door's swing": ({"shelf": "4.3, 1.7", "open": "20"}, "door_0 meets shelf"),
}


def found(text: str, folder: Path) -> list[str]:
    (folder / "room.yaml").write_text(text)
    for step in ("layout", "alignment"):
        scene = compose_room(folder / "room.yaml", folder / "out", only=step).scene
    return wrong(text, scenes.read(scene))


def wrong(text: str, scene: scenes.Scene) -> list[str]:
    rows = parse_room(text).furniture.objects
    supports = checks.described_supports(rows, lambda name: category(name).support)
    hanging = checks.described_hanging(rows, lambda name: category(name).placements)
    return checks.violations(scene, supports, hanging)


def found_in(room_type: str, seed: int, area: float | None, folder: Path) -> list[str]:
    """What is wrong with a room that is lived in."""
    shapes = Shapes(seed)
    text = write(generate(room_type, seed, area, clutter=2, shapes=shapes))
    return wrong(text, assembled(text, shapes, folder))


@pytest.mark.one_in(3, rest="long")
@pytest.mark.slow
@pytest.mark.parametrize("room_type", PROGRAMS)
def test_generated_rooms_are_sound(room_type: str, tmp_path: Path) -> None:
    """Small rooms, which are the crowded ones; `benchmarks.generate` checks a thousand."""
    least, usual, _ = PROGRAMS[room_type].area
    assert found_in(room_type, 100, 0.5 * (least + usual), tmp_path) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(200, 204))
@pytest.mark.parametrize("room_type", ["bathroom", "kitchen"])
def test_what_is_built_in_is_sound(room_type: str, seed: int, tmp_path: Path) -> None:
    assert found_in(room_type, seed, None, tmp_path) == []


@pytest.mark.slow
def test_a_plain_room_is_sound(tmp_path: Path) -> None:
    assert found(PLAIN.format(**GOOD), tmp_path) == []


@pytest.mark.one_in(10)
@pytest.mark.parametrize("name", PLANTED)
def test_what_is_planted_is_found(name: str, tmp_path: Path) -> None:
    change, wanted = PLANTED[name]
    problems = found(PLAIN.format(**(GOOD | change)), tmp_path)
    assert any(problem.startswith(wanted) for problem in problems), problems


@pytest.mark.slow
def test_cut_off_doors_and_walled_in_beds_are_found(tmp_path: Path) -> None:
    row = "    - {{name: wall_{i}, category: wardrobe, at: [3, {y}], size: [1, 0.6, 2], yaw: 90}}\n"
    across = "".join(row.format(i=i, y=0.6 + 0.95 * i) for i in range(4)).replace("{{", "{")
    text = PLAIN.format(**GOOD) + across.replace("}}", "}")
    assert "some doors are cut off from others" in found(text, tmp_path)


@pytest.mark.slow
def test_one_inside_another_is_found(tmp_path: Path) -> None:
    text = PLAIN.format(**GOOD) + (
        "    - {name: carton, category: box, at: [3.5, 1], size: [1, 1, 1]}\n"
        "    - {name: hidden, category: box, at: [3.5, 1, 0.3], size: [0.2, 0.2, 0.2]}\n"
    )
    assert any("penetrates" in problem and "hidden" in problem for problem in found(text, tmp_path))


@pytest.mark.slow
def test_what_is_draped_must_hang(tmp_path: Path) -> None:
    row = (
        "    - {name: towel, category: towel, style: draped, size: [0.33, 0.048, 0.45], yaw: 180, "
    )
    rail = (
        "    - {name: rail, category: towel_rail, at: [1.873, 0.01, 1.1], on: wall, style: bar, "
        "size: [0.54, 0.075, 0.05]}\n"
    )
    text = PLAIN.format(**GOOD) + rail
    assert found(text + row + "at: [1.8548, 0.0667, 0.698], on: rail}\n", tmp_path) == []
    assert found(text + row + "at: [1.8548, 0.0667, 0.5], on: rail}\n", tmp_path) != []
    standing = found(text + row + "at: [1.7, 2.5, 0.74], on: table}\n", tmp_path)
    assert "towel does not hang on table" in standing
