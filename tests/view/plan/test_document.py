"""A plan is saved so that it composes, and refused in the words of compose; drafts lose nothing."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from pxr import Usd

import openrooms_usd as ou
from openrooms_usd import names
from openrooms_usd.building.shell import Hole
from openrooms_usd.cli import orusd
from openrooms_usd.description import load_room
from openrooms_usd.errors import DescriptionError, InputError, OrusdError, OutputError
from openrooms_usd.view.app import Nothing
from openrooms_usd.view.plan.corners import move_corner, move_wall, split_wall
from openrooms_usd.view.plan.document import Document
from openrooms_usd.view.plan.fittings import add_opening, set_height, set_opening
from openrooms_usd.view.plan.session import Session

PLAN = "layout:\n  polygon: [[0, 0], [5, 0], [5, 4], [0, 4]]\n"
DRAWN = """\
# A room of our own
name: mine  # and nobody else's
layout:
  # in centimetres
  polygon: [[0, 0], [500 cm, 0], [500 cm, 4], [0, 4]]
  height: 240 cm  # low
  openings:
    - {kind: door, wall: 2, style: glazed, open: 30 deg}  # to the garden
  trim: {skirting: true}

cameras: {views: [{from: select, count: 1}]}
"""
BOXES = "id,label,x,y,z,width,depth,height,yaw\na,chair,1,2,0,0.5,0.6,0.9,30\n"


@pytest.fixture
def drawn(tmp_path: Path) -> Document:
    file = tmp_path / "room.yaml"
    file.write_text(DRAWN, encoding="utf-8")
    return Document(file)


@pytest.fixture
def boxed(tmp_path: Path) -> Document:
    (tmp_path / "boxes.csv").write_text(BOXES)
    file = tmp_path / "room.yaml"
    text = "layout: {from: boxes, file: boxes.csv}\nfurniture: {from: boxes, file: boxes.csv}\n"
    file.write_text(text)
    return Document(file)


def floor_of(out: Path) -> list[list[float]]:
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    attribute = stage.GetPrimAtPath(names.ROOM).GetAttribute(names.ROOM_FLOOR)
    return [list(point) for point in attribute.Get()]


def test_nothing_that_was_not_changed_is_written_anew(drawn: Document) -> None:
    drawn.save(drawn.saved)
    assert drawn.file.read_text() == DRAWN
    drawn.save(set_height(drawn.saved, 2.5))
    assert drawn.file.read_text() == DRAWN.replace("240 cm", "2.5")


def test_a_step_that_is_taken_back_is_saved_with_equal_bytes(drawn: Document) -> None:
    session = Session(drawn.file)
    commands = session.app().commands
    for name, given in (
        ("move_wall", {"wall": 1, "by": [0.25, 0.0]}),
        ("split_wall", {"wall": 0, "at": [2.0, 0.0]}),
        ("add_opening", {"wall": 0, "rectangle": [0.5, 1.5, 1.0, 2.0]}),
        ("set_height", {"height": 3.0}),
    ):
        commands[name].run(commands[name].model.model_validate(given))
    told = commands["save"].run(Nothing())
    assert not told["unsaved"] and drawn.file.read_text() != DRAWN
    for _ in range(4):
        told = commands["undo"].run(Nothing())
    assert told["unsaved"]
    commands["save"].run(Nothing())
    room, before = load_room(drawn.file), drawn.saved
    assert Document(drawn.file).saved.as_section() == before.as_section()
    assert room.layout.trim.skirting is not None
    kept = [line for line in DRAWN.splitlines() if "#" in line and "garden" not in line]
    text = drawn.file.read_text()
    assert all(line.partition("#")[2] in text for line in kept)


def test_a_changed_room_composes_with_the_change(drawn: Document, tmp_path: Path) -> None:
    plan = move_wall(drawn.saved, 1, 0.5)
    plan = add_opening(plan, Hole(1.0, 2.2, 0.9, 2.0), wall=0)
    drawn.save(set_height(plan, 2.75))
    ou.compose(drawn.file, tmp_path / "out", only="layout")
    assert max(x for x, _ in floor_of(tmp_path / "out")) == 5.5
    stage = Usd.Stage.Open(str(tmp_path / "out/scene.usda"))
    room = stage.GetPrimAtPath(names.ROOM)
    assert room.GetAttribute("openrooms:room:height").Get() == 2.75
    kinds = {
        str(prim.GetName()): prim.GetAttribute("openrooms:opening:width").Get()
        for prim in stage.GetPrimAtPath(names.OPENINGS).GetChildren()
    }
    assert kinds == pytest.approx({"door_0": 0.9, "window_0": 1.2})


def test_the_plan_of_a_capture_is_drawn_in_place_of_what_was_captured(
    boxed: Document, tmp_path: Path
) -> None:
    before = boxed.saved.area
    plan = add_opening(move_wall(boxed.saved, 0, 0.5), Hole(0.5, 1.3, 0.0, 2.0), wall=0)
    boxed.save(plan)
    layout = load_room(boxed.file).layout
    assert layout.source == "boxes" and layout.polygon is not None
    ou.compose(boxed.file, tmp_path / "out")
    stage = Usd.Stage.Open(str(tmp_path / "out/scene.usda"))
    assert np.allclose(floor_of(tmp_path / "out"), plan.corners, atol=1e-4)
    assert stage.GetPrimAtPath(f"{names.OPENINGS}/door_0").IsValid()
    assert stage.GetPrimAtPath("/World/Furniture").GetChildren()
    assert Document(boxed.file).saved.area > before


@pytest.mark.parametrize(
    "wrong",
    [
        lambda plan: move_corner(plan, 0, (6.0, 2.0)),
        lambda plan: move_corner(plan, 0, (5.0, 0.0)),
        lambda plan: add_opening(plan, Hole(-1.0, 2.0, 0.9, 2.0), wall=1),
        lambda plan: set_opening(plan, 0, hole=Hole(1.0, 2.0, 0.0, 2.39)),
        lambda plan: add_opening(plan, Hole(1.5, 3.0, 0.0, 2.0), wall=2),
        lambda plan: set_height(plan, 1000.0),
        lambda plan: split_wall(plan, 2, (2.3, 4.0)),
    ],
)
def test_what_compose_would_refuse_is_refused_in_its_words(
    drawn: Document, tmp_path: Path, wrong: object
) -> None:
    plan = wrong(drawn.saved)  # type: ignore[operator]
    said = drawn.refusal(plan)
    assert said is not None
    with pytest.raises(type(said)) as saved:
        drawn.save(plan)
    assert drawn.file.read_text() == DRAWN
    drawn.file.write_text(drawn.text_of(plan))
    with pytest.raises(DescriptionError) as composed:
        ou.compose(drawn.file, tmp_path / "out")
    assert str(saved.value) == str(said) == str(composed.value)
    assert said.place == composed.value.place and said.remedy == composed.value.remedy


def test_a_page_that_is_closed_loses_nothing(drawn: Document) -> None:
    first = Session(drawn.file)
    commands = first.app().commands
    for by in (0.2, 0.3):
        given = commands["move_wall"].model(wall=1, by=(by, 0.0))
        commands["move_wall"].run(given)
    second = Session(drawn.file)
    assert second.state()["draft"] and second.state()["area"] == pytest.approx(20.0)
    answer = second.app().commands["draft"]
    told = answer.run(answer.model(take=True))
    assert told["area"] == pytest.approx(22.0) and told["undo"] == 1
    second.app().commands["save"].run(Nothing())
    assert not second.document.draft.exists()
    assert not Session(drawn.file).state()["draft"]


def test_a_draft_that_is_dropped_or_damaged_is_no_draft(drawn: Document) -> None:
    drawn.keep(move_wall(drawn.saved, 1, 0.2))
    session = Session(drawn.file)
    answer = session.app().commands["draft"]
    assert answer.run(answer.model(take=False))["undo"] == 0
    assert not drawn.draft.exists()
    for damaged in ("", "[]", '{"layout": 3}', json.dumps({"layout": {"polygon": "x"}})):
        drawn.draft.write_text(damaged)
        assert drawn.kept() is None


def test_what_another_program_writes_is_one_more_step(drawn: Document) -> None:
    session = Session(drawn.file)
    commands = session.app().commands
    commands["move_wall"].run(commands["move_wall"].model(wall=1, by=(0.2, 0.0)))
    drawn.file.write_text(DRAWN.replace("name: mine", "name: ours").replace("240 cm", "3"))
    with pytest.raises(OutputError, match="another program"):
        commands["save"].run(Nothing())
    told = commands["reload"].run(Nothing())
    assert (told["height"], told["area"], told["undo"]) == (3.0, pytest.approx(20.0), 2)
    told = commands["undo"].run(Nothing())
    assert told["area"] == pytest.approx(20.8)
    commands["save"].run(Nothing())
    text = drawn.file.read_text()
    assert "name: ours" in text and "to the garden" in text


def test_another_section_that_changes_is_no_step(drawn: Document) -> None:
    session = Session(drawn.file)
    drawn.file.write_text(DRAWN.replace("name: mine", "name: ours"))
    assert session.app().commands["reload"].run(Nothing())["undo"] == 0
    commands = session.app().commands
    commands["set_height"].run(commands["set_height"].model(height=2.6))
    commands["save"].run(Nothing())
    assert "name: ours" in drawn.file.read_text()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("", False),
        ("  cladding: [{bottom: 0, top: 1}]\n", False),
        ("  cladding: [{walls: [1], bottom: 0, top: 1}]\n", True),
        ("materials: {accents: {wall_2: paint}}\n", True),
    ],
)
def test_numbers_that_become_other_walls_are_told(tmp_path: Path, more: str, said: bool) -> None:
    file = tmp_path / "room.yaml"
    file.write_text(f"layout:\n  polygon: [[0, 0], [5, 0], [5, 4], [0, 4]]\n{more}")
    commands = Session(file).app().commands
    split, move = commands["split_wall"], commands["move_wall"]
    assert not move.run(move.model(wall=1, by=(0.1, 0.0)))["renumbered"]
    assert split.run(split.model(wall=0, at=(2.0, 0.0)))["renumbered"] is said


def test_walls_of_a_seed_are_not_moved(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text("room: kitchen\nlayout: {from: generate}\n")
    with pytest.raises(InputError, match="come from its seed"):
        Session(tmp_path / "room.yaml")


def run(*words: object) -> Result:
    return CliRunner().invoke(orusd, ["edit", "layout", *map(str, words)])


def test_a_plan_is_written_as_a_page(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text(PLAN)
    done = run(tmp_path / "room.yaml", "--export", tmp_path / "plan.html")
    assert (done.exit_code, done.output) == (0, f"wrote {tmp_path / 'plan.html'}\n")
    text = (tmp_path / "plan.html").read_text()
    assert '"corners":[[0.0,0.0],[5.0,0.0],[5.0,4.0],[0.0,4.0]]' in text
    assert str(tmp_path) not in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["scan.npz"], "needs a folder"),
        (["scan.npz", "-o", "out"], "unit"),
        (["room.yaml"], "did you mean 'height'"),
        (["none.yaml"], "none.yaml"),
    ],
)
def test_what_cannot_be_opened_is_told_and_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez("scan.npz", points=np.random.default_rng(0).uniform(0, 1e-4, (500, 3)))
    Path("room.yaml").write_text(PLAN + "  hieght: 3\n")
    done = run(*words, "--export", "plan.html")
    assert isinstance(done.exception, OrusdError) and said in str(done.exception)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["room.yaml", "scan.npz"]
