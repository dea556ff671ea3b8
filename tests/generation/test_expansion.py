"""``from: generate`` inside a description."""

import subprocess
import sys
from pathlib import Path

import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.description import dump_room, load_room, parse_room
from openrooms_usd.description.furniture import ObjectList
from openrooms_usd.description.layout import PolygonLayout
from openrooms_usd.generation import expanded, generate, write
from openrooms_usd.generation.shell import shell_of

# Textures are none of this folder's business.
SMALL = "materials: {resolution: 16}\n"


@pytest.mark.slow
def test_a_generated_layout_brings_furniture() -> None:
    room = expanded(parse_room("room: bedroom\nseed: 4\nlayout: {from: generate}\n"))
    same = parse_room(write(generate("bedroom", 4)))
    assert isinstance(room.layout, PolygonLayout)
    assert room.layout.polygon == same.layout.polygon
    assert room.layout.openings == same.layout.openings
    assert room.furniture == same.furniture
    assert room.lights.lamps == same.lights.lamps
    assert parse_room(dump_room(room)) == room


def test_listed_furniture_stays() -> None:
    text = "room: office\nlayout: {from: generate, area: 14}\nfurniture: {objects: []}\n"
    room = expanded(parse_room(text))
    assert room.furniture == ObjectList()
    assert isinstance(room.layout, PolygonLayout)
    assert shell_of(room.layout).area == pytest.approx(14, rel=0.02)


def test_what_is_not_generated_is_not_touched() -> None:
    room = parse_room("room: office\nfurniture:\n  objects:\n    - {category: desk, at: [1, 1]}\n")
    assert expanded(room) is room


@pytest.mark.parametrize("turn", [1, -1])
def test_a_room_of_ones_own_is_furnished(turn: int) -> None:
    corners = [[0, 0], [4.5, 0], [4.5, 3.8], [0, 3.8]][::turn]
    room = expanded(
        parse_room(
            f"room: bedroom\nlayout:\n  polygon: {corners}\n  openings:\n"
            "    - {kind: door, wall: 0, at: 0.8}\n    - {kind: window, wall: 1}\n"
            "furniture: {from: generate}\nlights: {lamps: {ceiling_lamp: {on: false}}}\n"
        )
    )
    assert isinstance(room.furniture, ObjectList)
    assert {"bed", "ceiling_lamp"} <= {item.category for item in room.furniture.objects}
    assert room.lights.lamps["ceiling_lamp"].on is False
    assert [list(corner) for corner in room.layout.polygon] == corners


def test_given_lamps_keep_what_is_said_of_them() -> None:
    room = expanded(
        parse_room(
            "room: closet\nlayout: {from: generate}\nlights: {lamps: {ceiling_lamp: {lumen: 5}}}\n"
        )
    )
    assert room.lights.lamps["ceiling_lamp"].lumen == 5


@pytest.mark.slow
def test_composing_sees_the_expanded_room(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text("room: closet\nseed: 2\nlayout: {from: generate}\n" + SMALL)
    first = compose_room(tmp_path / "room.yaml", tmp_path / "out")
    again = compose_room(tmp_path / "room.yaml", tmp_path / "out")
    assert not first.unchanged and again.unchanged
    (tmp_path / "room.yaml").write_text("room: closet\nseed: 3\nlayout: {from: generate}\n" + SMALL)
    assert not compose_room(tmp_path / "room.yaml", tmp_path / "out").unchanged
    load_room(tmp_path / "room.yaml")


@pytest.mark.slow
def test_a_room_that_is_written_out_needs_no_generator(tmp_path: Path) -> None:
    """Composing again is quick because little is imported."""
    (tmp_path / "room.yaml").write_text(
        "layout: {polygon: [[0, 0], [4, 0], [4, 3], [0, 3]]}\nmaterials: {resolution: 256}\n"
    )
    script = (
        "import sys; from pathlib import Path; from openrooms_usd.composing import compose_room\n"
        "compose_room(Path('room.yaml'), Path('out'))\n"
        "slow = {'openrooms_usd.generation', 'shapely', 'scipy', 'trimesh', 'OpenImageIO'}\n"
        "print(slow & set(sys.modules))\n"
    )
    command = [sys.executable, "-c", script]
    runs = [subprocess.run(command, cwd=tmp_path, capture_output=True, text=True) for _ in "ab"]
    assert [run.returncode for run in runs] == [0, 0], runs[0].stderr
    assert runs[1].stdout.strip() == "set()"


DESCRIBED = """\
room: office
seed: 2
clutter: 2
layout: {polygon: [[0, 0], [3, 0], [3, 3], [0, 3]]}
furniture:
  objects:
    - {category: table, at: [1.5, 2.5], size: [1.6, 0.8, 0.74], style: four_legs}
"""


def test_things_lie_about_in_described_rooms_too() -> None:
    room = expanded(parse_room(DESCRIBED))
    assert isinstance(room.furniture, ObjectList)
    table, *others = room.furniture.objects
    assert room.clutter == 0 and table.name == "table_0" and others
    assert any(other.on == other.relative_to == "table_0" for other in others)
    assert expanded(room) == room
    bare = parse_room(DESCRIBED.replace("clutter: 2", "clutter: 0"))
    assert expanded(bare) == bare


@pytest.mark.parametrize("layout", ["{from: generate, area: 9}", "{from: polygon}"])
def test_clutter_lies_on_what_a_description_lists(layout: str) -> None:
    text = f"room: office\nseed: 2\nlayout: {layout}\nfurniture: {{objects: [{{category: table, "
    text += "at: [2, 1.4], size: [1.6, 0.8, 0.74]}]}\n"
    counts = [
        len(expanded(parse_room(f"clutter: {level}\n{text}")).furniture.objects) for level in (0, 3)
    ]
    assert counts[0] == 1 < counts[1]


def test_composing_lays_clutter_or_says_that_it_cannot(tmp_path: Path) -> None:
    told = []
    for level, out in ((3, "full"), (1, "bare"), (1, "bare")):
        room = parse_room(f"room: office\nseed: 2\nclutter: {level}\n")
        compose_room(room, tmp_path / out, only="layout")
        told.append(compose_room(room, tmp_path / out, only="furniture").notes)
    full, bare = (tmp_path / out / "layers/alignment.usda" for out in ("full", "bare"))
    assert full.read_text().count("references = @") > bare.read_text().count("references = @") == 0
    assert not any(note.startswith("clutter") for note in told[0])
    assert told[1][0].startswith("clutter: none was placed") and told[2] == told[1]
