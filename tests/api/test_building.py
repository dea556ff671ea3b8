"""Rooms built step by step are the descriptions that people would have written."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import openrooms_usd as ou
from openrooms_usd import description
from openrooms_usd.errors import DescriptionError, InputError
from tests.api.tiny import ROOM


def built() -> ou.Room:
    """`ROOM` of the other tests, step by step."""
    room = ou.new_room("office", width=4, depth=3, seed=3)
    room.add_window(wall=0)
    room.add("chair", at=(1.5, 0.8), yaw="180 deg")
    room.add("ceiling_lamp", at=np.array([2, 1.5]))
    room.add_camera((0.5, 0.5, 1.5), (2, 1.5, 1), name="left")
    room.add_camera((3.5, 0.5, 1.5), (2, 1.5, 1), name="right")
    room.update(materials={"resolution": 16}, cameras={"resolution": [16, 12]})
    return room


def test_a_built_room_is_the_one_that_was_written() -> None:
    room, written = built(), ou.load_room(ROOM)
    assert isinstance(room, description.Room)
    assert room.as_dict() == written.as_dict()


def test_what_is_added_goes_by_its_name(here: Path) -> None:
    room = ou.new_room(width=4, depth="300 cm")
    desk = room.add("table", at=(1.5, 1.5))
    lamp = room.add("table_lamp", at=(0.2, 0), on=desk, relative_to=desk, name="reading")
    room.set_lamp(lamp, lumen=300, kelvin=2700)
    room.set_material(desk, "oak_planks", part="tabletop")
    room.set_material("floor", "wood", number=3)
    room.set_material("wall_2", color=(0.2, 0.3, 0.2))
    room.set_environment(illuminance=500)
    names = [room.add_window(wall=1), room.add_door(wall=2, open=30), room.add_opening(wall=3)]
    assert [desk, lamp, *names] == ["table_0", "reading", "window_0", "door_0", "opening_0"]
    assert room.add_camera(world_from_camera=np.eye(4), fov=70) == "camera_0"
    room.select_cameras(2)
    assert ou.load_room(room.save("room/room.yaml")).as_dict() == room.as_dict()


def test_what_is_removed_takes_along_what_is_said_of_it() -> None:
    room = built()
    room.add("chair", at=(3, 2))
    room.set_lamp("ceiling_lamp_0", lumen=400)
    for name in ("ceiling_lamp_0", "chair_0"):
        room.remove(name)
    assert [thing.name for thing in room.furniture.objects] == ["chair_1"]  # type: ignore[union-attr]
    assert room.lights.lamps == {}
    with pytest.raises(InputError, match="no object is named 'chair_0'"):
        room.remove("chair_0")


@pytest.mark.parametrize(
    ("step", "field"),
    [
        (lambda room: room.add("chiar", (1, 1)), r"objects\[2\]\.category.*did you mean 'chair'"),
        (lambda room: room.add("chair", (1, 1), on="shelf"), r"objects\[2\]\.on"),
        (lambda room: room.add("chair", (1, 1), colour="red"), r"objects\[2\]\.colour"),
        (lambda room: room.add_window(wall=4), r"openings\[1\]\.wall.*no wall 4"),
        (lambda room: room.add_door(), "the key 'wall' is missing"),
        (lambda room: room.add_camera((1, 1, 1)), r"views\[2\]\.target"),
        (lambda room: room.set_lamp("lamp"), "lamps.lamp: no object"),
        (lambda room: room.set_material("floor", "oakplanks"), "floor.family.*'oak_planks'"),
        (lambda room: room.update(layuot={}), "layuot: unknown key"),
        (lambda room: setattr(room, "seed", -1), "seed"),
    ],
)
def test_a_mistake_names_its_field_and_changes_nothing(
    step: Callable[[ou.Room], object], field: str
) -> None:
    room = built()
    with pytest.raises(DescriptionError, match=field):
        step(room)
    assert room.as_dict() == built().as_dict()


def test_any_room_can_be_changed() -> None:
    room = ou.generate("closet", 2)
    before = len(room.furniture.objects)  # type: ignore[union-attr]
    name = room.add("trash_bin", at=(0.5, 0.5))
    room.seed = 4
    assert room.seed == 4 and len(room.furniture.objects) == before + 1  # type: ignore[union-attr]
    room.remove(name)
    copy = ou.load_room(room)
    copy.style = "rustic"
    assert room.style != "rustic"


def test_what_is_generated_later_is_named() -> None:
    room = ou.load_room({"room": "bedroom", "layout": {"from": "generate"}})
    with pytest.raises(InputError, match="generated when it is composed") as refused:
        room.add_window(wall=0)
    assert "ou.generate" in (refused.value.remedy or "")


def test_a_name_that_is_taken_is_refused() -> None:
    room = ou.new_room("office", width=4, depth=3)
    table = room.add("table", at=(1.5, 1.5))
    before = room.as_dict()
    with pytest.raises(ou.OrusdError, match="has this name"):
        room.add("desk", at=(3, 1), name=table)
    assert room.as_dict() == before


@pytest.mark.parametrize(
    "wrong", [{"clutter": 4}, {"clutter": -1}, {"clutter": "x"}, {"area": "4 m2"}]
)
def test_amounts_of_generated_rooms_are_checked(wrong: dict) -> None:
    with pytest.raises(ou.OrusdError, match=r"clutter|area"):
        ou.generate("bathroom", **wrong)
