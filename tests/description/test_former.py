"""The section `furniture` under its former name: the same room, with a note that names it."""

import filecmp
from pathlib import Path

import pytest
from click.testing import CliRunner
from jsonschema import Draft202012Validator

import openrooms_usd as ou
from openrooms_usd.cli import orusd
from openrooms_usd.composing import compose_room
from openrooms_usd.description import Room, parse_room, room_of
from openrooms_usd.description.furniture import ObjectList
from openrooms_usd.description.rewriting import rewritten
from openrooms_usd.description.schema import room_schema
from openrooms_usd.errors import DescriptionError
from openrooms_usd.view.describing import Described

NEW = """\
room: office
seed: 3
furniture:
  objects: [{category: stool, at: [1, 1]}]  # one
materials: {resolution: 16}
"""
OLD = NEW.replace("furniture:", "alignment:")
CHAIR = {"objects": [{"category": "chair", "at": [1, 1]}]}
NOTE = "`alignment` is called `furniture` now"


def test_a_file_says_the_same_room_and_a_note() -> None:
    old, new = parse_room(OLD), parse_room(NEW)
    assert old == new and old.as_dict() == new.as_dict()
    assert (old.notes, new.notes) == ((NOTE,), ())


def test_data_and_sections_say_the_same_room_and_a_note() -> None:
    new = room_of({"furniture": CHAIR})
    listed = ObjectList.model_validate(CHAIR)
    for old in (room_of({"alignment": CHAIR}), Room(alignment=CHAIR), Room(alignment=listed)):
        assert old == new and old.notes == (NOTE,)
        assert old.alignment == new.furniture


def test_rooms_that_are_built_take_it_and_keep_the_note() -> None:
    room = ou.Room(room="office")
    room.update(alignment=CHAIR)
    room.add("table", at=(3, 1))
    assert [thing.category for thing in room.furniture.objects] == ["chair", "table"]
    room.alignment = CHAIR
    assert len(room.furniture.objects) == 1
    assert room.notes == (NOTE,)


def test_both_names_at_once_are_refused_with_both_places() -> None:
    with pytest.raises(DescriptionError) as caught:
        parse_room(f"{NEW}alignment: {{}}\n")
    assert "room.yaml:6:1: alignment: the former name of `furniture`" in str(caught.value)
    assert "given too in line 3" in str(caught.value)
    for refused in (
        lambda: room_of({"alignment": CHAIR, "furniture": CHAIR}),
        lambda: Room(alignment=CHAIR, furniture=CHAIR),
    ):
        with pytest.raises(DescriptionError, match="alignment: the former name of `furniture`"):
            refused()


def test_mistakes_in_it_keep_their_places() -> None:
    wrong = "alignment:\n  objects: [{category: chair, at: [1, 1], colour: red}]\n"
    with pytest.raises(DescriptionError, match=r"2:43: furniture.objects\[0\].colour: unknown key"):
        parse_room(wrong)
    with pytest.raises(DescriptionError, match=r"furniture.objects\[0\].at: required"):
        Room(alignment={"objects": [{"category": "chair"}]})


def test_an_editor_keeps_the_name_that_a_file_has(tmp_path: Path) -> None:
    more = {"objects": [{"category": "chair", "at": [2, 1]}]}
    old, new = (rewritten(text, "furniture", more) for text in (OLD, NEW))
    assert old == new.replace("furniture:", "alignment:") and "chair" in old
    file = tmp_path / "room.yaml"
    file.write_text(OLD)
    assert Described(file, tmp_path / "out/scene.usda").section("furniture")["objects"]


def test_the_schema_takes_either_name_but_not_both() -> None:
    valid = Draft202012Validator(room_schema()).is_valid
    assert valid({"furniture": CHAIR}) and valid({"alignment": CHAIR})
    assert not valid({"furniture": CHAIR, "alignment": CHAIR})
    assert not valid({"alignment": {"objects": [{"category": "chiar", "at": [1, 1]}]}})


def test_equal_rooms_compose_to_the_same_bytes(tmp_path: Path) -> None:
    for name, text in (("old", OLD), ("new", NEW)):
        summary = compose_room(parse_room(text), tmp_path / name)
        assert (NOTE in summary.notes) == (name == "old")
    old, new = (
        sorted(p.relative_to(tmp_path / name) for p in (tmp_path / name).rglob("*") if p.is_file())
        for name in ("old", "new")
    )
    assert old == new and Path("layers/alignment.usda") in old
    same, *others = filecmp.cmpfiles(tmp_path / "old", tmp_path / "new", old, shallow=False)
    assert len(same) == len(old) and others == [[], []]
    again = compose_room(parse_room(OLD), tmp_path / "new", only="alignment")
    assert again.unchanged and again.notes.count(NOTE) == 1


def test_the_step_has_both_names_too(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text(NEW)
    words = ["compose", str(tmp_path / "room.yaml"), "-o", str(tmp_path / "out")]
    assert CliRunner().invoke(orusd, words).exit_code == 0
    runs = {
        name: CliRunner().invoke(orusd, [*words, "--only", name])
        for name in ("furniture", "alignment")
    }
    assert [NOTE in run.output for run in runs.values()] == [False, True]
    assert all("\nfurniture " in f"\n{run.stdout}" for run in runs.values())
