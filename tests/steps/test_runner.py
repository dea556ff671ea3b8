"""Stages are run when what they depend on has changed, and only then; a failure changes nothing."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdGeom

import openrooms_usd as ou
from openrooms_usd import atomic
from openrooms_usd.composing import ComposeSummary, compose_room
from openrooms_usd.description.room import Room
from openrooms_usd.errors import InputError, OutputError, StageError
from openrooms_usd.steps import base, runner
from openrooms_usd.steps.base import StepContext
from openrooms_usd.usd.files.diagnostics import composition_errors


class FakeLayout:
    name = "layout"
    reads: tuple[str, ...] = ()
    broken = False

    def inputs(self, room: Room, source: Path) -> Iterator[str]:
        yield "input.txt"

    def author(self, context: StepContext) -> None:
        text = context.input("input.txt").read_text()
        context.notes.append(f"a guess by {text}")
        UsdGeom.Xform.Define(context.stage, "/World")
        mesh = UsdGeom.Mesh.Define(context.stage, "/World/Room")
        mesh.CreatePointsAttr([(float(len(text)), float(i), 0.0) for i in range(100)])
        atomic.write_text(context.keep(f"file-{text}.txt"), text)
        if self.broken:
            raise InputError("the planted failure")


class FakeAlignment:
    name = "alignment"
    reads = ("layout",)

    def inputs(self, room: Room, source: Path) -> Iterator[str]:
        yield from ()

    def author(self, context: StepContext) -> None:
        points = UsdGeom.Mesh(context.stage.GetPrimAtPath("/World/Room")).GetPointsAttr().Get()
        prim = UsdGeom.Xform.Define(context.stage, "/World/Furniture").GetPrim()
        prim.CreateAttribute("seen", Sdf.ValueTypeNames.Int).Set(len(points))
        prim.CreateAttribute("draw", Sdf.ValueTypeNames.Double).Set(
            context.rng("alignment", "a").random()
        )


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(runner, "steps", lambda: [FakeLayout(), FakeAlignment()])
    (tmp_path / "room.yaml").write_text("seed: 1\n")
    (tmp_path / "input.txt").write_text("one")
    return tmp_path


def compose(place: Path) -> ComposeSummary:
    return compose_room(place / "room.yaml", place / "out", workers=1)


def states(summary: ComposeSummary) -> list[str]:
    return [row.state for row in summary.stages]


def tree(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_a_second_compose_does_nothing(place: Path) -> None:
    assert states(compose(place)) == ["written", "written"]
    before = tree(place / "out")
    summary = compose(place)
    assert summary.unchanged
    assert tree(place / "out") == before


def test_notes_are_there_after_a_compose_that_did_nothing(place: Path) -> None:
    first, again = (
        ou.compose(place / "room.yaml", place / "out", workers=1) for _ in ("first", "again")
    )
    assert again.composed is not None and again.composed.unchanged
    assert first.notes == again.notes == ou.open_scene(first.path).notes == ("a guess by one",)


def test_what_a_step_reads_runs_it_again_and_old_files_go(place: Path) -> None:
    compose(place)
    (place / "input.txt").write_text("three")
    assert states(compose(place)) == ["written", "written"]
    names = [path.name for path in sorted((place / "out" / "layers" / "layout").iterdir())]
    assert len(names) == 2
    assert names[0].startswith("arrays-")
    assert names[1] == "file-three.txt"


def test_what_people_put_among_the_files_of_a_step_stays_and_is_named(place: Path) -> None:
    compose(place)
    layout = place / "out" / "layers" / "layout"
    (layout / "wood.png").write_text("mine")
    (layout / "file-one.txt").write_text("changed by hand")
    (place / "input.txt").write_text("three")
    assert compose(place).notes == (
        "layers/layout/file-one.txt and 1 more stay: no layer refers to it, and compose did not "
        "write it as it is now",
    )
    assert (layout / "wood.png").read_text() == "mine"
    assert (layout / "file-one.txt").read_text() == "changed by hand"
    assert compose(place).notes == ()


def test_a_folder_given_relatively_is_the_same(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compose(place)
    before = tree(place / "out")
    monkeypatch.chdir(place)
    for text in ("three", "one"):
        (place / "input.txt").write_text(text)
        summary = compose_room(Path("room.yaml"), Path("out"))
        assert [row.state for row in summary.stages] == ["written", "written"]
        assert summary.notes == ()
    assert tree(place / "out") == before


def test_a_layer_that_was_changed_by_hand_is_not_written_anew(place: Path) -> None:
    compose(place)
    layer = place / "out" / "layers" / "layout.usda"
    changed = f"{layer.read_text()}# mine\n"
    layer.write_text(changed)
    assert states(compose(place)) == ["unchanged", "written"]
    (place / "input.txt").write_text("three")
    with pytest.raises(StageError, match="was changed by hand"):
        compose(place)
    assert layer.read_text() == changed
    layer.unlink()
    assert states(compose(place)) == ["written", "written"]


def test_nothing_is_written_through_a_link(place: Path) -> None:
    compose(place)
    (place / "out" / "layers").rename(place / "elsewhere")
    (place / "out" / "layers").symlink_to(place / "elsewhere")
    before = tree(place / "elsewhere")
    (place / "input.txt").write_text("three")
    with pytest.raises(StageError, match="this is a symbolic link"):
        compose(place)
    assert tree(place / "elsewhere") == before


def test_a_missing_file_of_a_layer_is_made_again(place: Path) -> None:
    compose(place)
    before = tree(place / "out")
    (place / "out" / "layers" / "layout" / "file-one.txt").unlink()
    assert states(compose(place)) == ["written", "unchanged"]
    assert tree(place / "out") == before


def test_the_seed_changes_the_draws_and_equal_seeds_give_equal_bytes(place: Path) -> None:
    compose(place)
    first = tree(place / "out")
    (place / "room.yaml").write_text("seed: 2\n")
    compose(place)
    changed = tree(place / "out")
    assert changed["layers/alignment.usda"] != first["layers/alignment.usda"]
    (place / "room.yaml").write_text("seed: 1\n")
    compose(place)
    assert tree(place / "out") == first


def test_a_failing_step_leaves_the_layers_as_they_were(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compose(place)
    before = tree(place / "out")
    (place / "input.txt").write_text("two")
    monkeypatch.setattr(FakeLayout, "broken", True)
    with pytest.raises(InputError, match="planted"):
        compose(place)
    after = tree(place / "out")
    assert {name: after[name] for name in before} == before


def test_edits_are_made_once_read_by_steps_and_never_written_again(place: Path) -> None:
    compose(place)
    edits = place / "out" / "layers" / "edits.usda"
    layer = Sdf.Layer.FindOrOpen(str(edits))
    points = UsdGeom.Tokens.points
    spec = Sdf.CreatePrimInLayer(layer, "/World/Room")
    Sdf.AttributeSpec(spec, points, Sdf.ValueTypeNames.Point3fArray).default = [(0, 0, 0)] * 7
    layer.Save()
    edited = edits.read_bytes()
    assert states(compose(place)) == ["written", "written"]
    assert edits.read_bytes() == edited
    stage = Usd.Stage.Open(str(place / "out" / "scene.usda"))
    assert stage.GetPrimAtPath("/World/Furniture").GetAttribute("seen").Get() == 7


def test_only_runs_one_step(place: Path) -> None:
    compose(place)
    (place / "input.txt").write_text("two")
    summary = compose_room(place / "room.yaml", place / "out", only="furniture")
    assert [(row.stage, row.state) for row in summary.stages] == [("alignment", "unchanged")]


def test_an_unknown_step_is_refused(place: Path) -> None:
    with pytest.raises(InputError, match="no step is named 'layuot'"):
        compose_room(place / "room.yaml", place / "out", only="layuot")


def test_the_root_layer_holds_metadata_and_sublayers_only(place: Path) -> None:
    compose(place)
    scene = Sdf.Layer.FindOrOpen(str(place / "out" / "scene.usda"))
    assert list(scene.subLayerPaths) == [
        "./layers/edits.usda",
        "./layers/alignment.usda",
        "./layers/layout.usda",
    ]
    assert not scene.rootPrims
    stage = Usd.Stage.Open(scene)
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0


def test_output_that_cannot_be_written_is_explained(place: Path) -> None:
    (place / "out").write_text("a file where the folder should be")
    with pytest.raises(Exception, match="cannot write") as caught:
        compose(place)
    assert "remedy" in str(caught.value)


@pytest.mark.parametrize("data", [b"\xff\xfe\x00nonsense", b"mine"])
def test_a_root_layer_that_is_no_layer_may_be_somebodys(data: bytes, place: Path) -> None:
    compose(place)
    scene = place / "out" / "scene.usda"
    wanted = scene.read_bytes()
    scene.write_bytes(data)
    with pytest.raises(OutputError, match="would be replaced"):
        compose(place)
    assert scene.read_bytes() == data
    scene.write_bytes(b"")
    compose(place)
    assert scene.read_bytes() == wanted


def test_the_name_of_the_room_runs_nothing_again(place: Path) -> None:
    compose(place)
    (place / "room.yaml").write_text("seed: 1\nname: another\n")
    assert states(compose(place)) == ["unchanged", "unchanged"]


def test_an_input_that_cannot_be_read_is_named(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match="cannot read"):
        base.file_digest(place)

    def refuse(path: Path, *rest: object, **more: object) -> None:
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "stat", refuse)
        with pytest.raises(InputError, match="cannot read: Permission denied"):
            base.input_file(place, "input.txt")
    # A superuser may read everything, so the system is made to refuse.
    with monkeypatch.context() as patched:
        patched.setattr(Path, "open", refuse)
        with pytest.raises(InputError, match="cannot read: Permission denied") as caught:
            base.file_digest(place / "input.txt")
    assert caught.value.place == str(place / "input.txt")


def test_what_usd_says_has_no_addresses() -> None:
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().ImportFromString(
        '#usda 1.0\ndef "A" (\n    references = </Nowhere>\n) {}\n'
    )
    [(prim, text)] = composition_errors(stage)
    assert prim == "/A"
    assert "/Nowhere" in text
    assert "@anon" not in text and "0x" not in text
