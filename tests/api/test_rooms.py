"""Ways to a room and into USD: every form gives the same layers."""

import copy
import json
from pathlib import Path

import pytest
from pxr import UsdGeom

import openrooms_usd as ou
from openrooms_usd.errors import DescriptionError, InputError, OutputError, StageError
from openrooms_usd.generation import generate, write
from tests.api.tiny import ROOM


def layers(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (out / "layers").glob("*.usda")}


@pytest.mark.slow
def test_a_dict_a_room_and_a_file_compose_alike(scene: ou.Scene, here: Path) -> None:
    file = ou.load_room(ROOM).save("room/room.yaml")
    for number, room in enumerate((ou.load_room(ROOM), "room/room.yaml", file, "room")):
        ou.compose(room, f"out{number}")
        assert layers(here / f"out{number}") == layers(scene.folder)


def test_a_generated_room_is_that_of_the_command(here: Path) -> None:
    room = ou.generate("closet", 2)
    (here / "room.yaml").write_text(write(generate("closet", 2, clutter=2)))
    assert room.as_dict() == ou.load_room("room.yaml").as_dict()
    assert list(here.iterdir()) == [here / "room.yaml"]


@pytest.mark.parametrize("bad", [-1, 1.5, 2**63])
def test_what_is_no_seed_is_refused(bad: int) -> None:
    with pytest.raises(InputError, match="must be a whole number of at least 0"):
        ou.generate("closet", bad)


def test_a_capture_becomes_a_room_that_composes(here: Path) -> None:
    boxes = [{"id": "a", "label": "bed", "center": [1, 2, 0.3], "size": [1.6, 2, 0.6]}]
    floor = [[0, 0], [4, 0], [4, 3.5], [0, 3.5]]
    Path("captured.json").write_text(json.dumps({"objects": boxes, "floor": floor, "height": 2.5}))
    imported = ou.import_capture("captured.json", "room", kind="boxes")
    assert imported.counts["objects"] == 1 and "4 walls" in repr(imported)
    assert imported.room.folder == Path("room")
    scene = ou.compose(imported.room, "out", only="layout")
    assert scene.path == Path("out/scene.usda")
    ou.import_capture("captured.json", "room", kind="boxes")
    imported.file.write_text("room: misc\n")
    with pytest.raises(OutputError, match="already has a room"):
        ou.import_capture("captured.json", "room", kind="boxes")
    with pytest.raises(InputError, match="no importer is named"):
        ou.import_capture("captured.json", "room", kind="boxs")


def test_mistakes_name_the_place_in_the_data(here: Path) -> None:
    wrong = copy.deepcopy(ROOM)
    wrong["furniture"]["objects"][0]["colour"] = "red"
    for refused in (lambda: ou.load_room(wrong), lambda: ou.compose(wrong, "out")):
        with pytest.raises(DescriptionError, match=r"furniture\.objects\[0\]\.colour: unknown key"):
            refused()
    assert list(here.iterdir()) == []


@pytest.mark.parametrize("wrong", [3, None, ["a"]])
def test_what_is_no_room_is_refused(wrong: object, here: Path) -> None:
    with pytest.raises(InputError, match="expected a room, a dict or a path"):
        ou.compose(wrong, "out")  # type: ignore[arg-type]


def test_a_scene_says_what_it_is(scene: ou.Scene) -> None:
    assert list(scene.cameras) == ["left", "right"]
    assert list(scene.objects) == ["chair_0", "ceiling_lamp_0"]
    assert "6 steps written" in repr(scene)
    for path in (scene, str(scene.path), scene.folder, str(scene.folder)):
        opened = ou.open_scene(path)
        assert opened.path == scene.path and opened.composed is None


def test_a_room_in_the_place_of_a_scene_is_explained() -> None:
    for room in (ROOM, ou.load_room(ROOM)):
        with pytest.raises(InputError) as refused:
            ou.render(room)  # type: ignore[arg-type]
        assert "ou.compose" in (refused.value.remedy or "")


def test_what_has_no_physics_is_named(scene: ou.Scene) -> None:
    for simulate in (ou.simulate, ou.robots.load_world):
        with pytest.raises(StageError, match="stage has no physics") as refused:
            simulate(scene)
        assert refused.value.place == str(scene.path)


@pytest.mark.slow
def test_edits_are_kept_and_dropped(here: Path) -> None:
    scene = ou.compose(ROOM, "out")
    untouched = scene.edits.read_bytes()
    path = "/World/Furniture/chair_0"

    def place() -> tuple[float, ...]:
        stage = scene.stage()
        chair = UsdGeom.Xformable(stage.GetPrimAtPath(path))
        return tuple(chair.ComputeLocalToWorldTransform(0).ExtractTranslation())

    before = place()
    with pytest.raises(ZeroDivisionError), scene.editing() as stage:
        UsdGeom.XformCommonAPI(stage.GetPrimAtPath(path)).SetTranslate((3, 2, 0))
        raise ZeroDivisionError
    assert scene.edits.read_bytes() == untouched and place() == before
    with scene.editing() as stage:
        UsdGeom.XformCommonAPI(stage.GetPrimAtPath(path)).SetTranslate((3, 2, 0))
    assert place() == pytest.approx((3, 2, 0))
    ou.compose(ROOM, "out")
    assert place() == pytest.approx((3, 2, 0))


def test_edits_that_break_the_room_are_refused(here: Path) -> None:
    scene = ou.compose(ROOM, "out")
    untouched = scene.edits.read_bytes()
    with pytest.raises(StageError), scene.editing() as stage:
        stage.OverridePrim("/World/Furniture/chair_0").GetReferences().AddReference("./gone.usda")
    assert scene.edits.read_bytes() == untouched
    assert ou.compose(ROOM, "out").orphans == ()


def test_only_composed_rooms_are_edited(here: Path) -> None:
    (here / "scene.usda").write_text("#usda 1.0\n")
    with (
        pytest.raises(InputError, match="not a composed room"),
        ou.open_scene("scene.usda").editing(),
    ):
        pass
    assert [path.name for path in here.iterdir()] == ["scene.usda"]
