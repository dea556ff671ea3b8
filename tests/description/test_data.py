"""A room from Python's own data: equal to the file's, and refused in the file's own words."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from openrooms_usd.description import Room, load_room, parse_room, room_of
from openrooms_usd.errors import DescriptionError

DATA: dict[str, Any] = {
    "room": "office",
    "layout": {"polygon": [[0, 0], ["420 cm", 0], [4.2, 3], [0, 3]]},
    "furniture": {"objects": [{"category": "chair", "at": [1, 2], "yaw": "90 deg"}]},
}


def wrong(path: tuple[str | int, ...], value: Any) -> dict[str, Any]:
    """`DATA` with something else in one place."""
    data: Any = yaml.safe_load(yaml.safe_dump(DATA))
    inner = data
    for step in path[:-1]:
        inner = inner[step]
    inner[path[-1]] = value
    return data  # type: ignore[no-any-return]


def test_data_makes_the_room_of_the_file() -> None:
    assert room_of(DATA) == parse_room(yaml.safe_dump(DATA)) == Room(**DATA)


def test_what_a_room_says_of_itself_makes_it_again() -> None:
    room = room_of(DATA)
    assert room_of(room.as_dict()) == room
    assert "90" in str(room.as_dict()["furniture"]["objects"][0]["yaw"])


def test_tuples_and_numpy_are_lists_and_numbers() -> None:
    corners = np.array([[0, 0], [4.2, 0], [4.2, 3], [0, 3]])
    chair = {"category": "chair", "at": (np.float32(1), np.int64(2)), "yaw": "90 deg"}
    data = {"room": "office", "layout": {"polygon": corners}, "furniture": {"objects": (chair,)}}
    assert room_of(data) == room_of(DATA)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("rom",), "office"),
        (("room",), "offic"),
        (("layout", "polygon"), [[0, 0], [1, 0]]),
        (("layout", "polygon", 1), [1, 2, 3]),
        (("furniture", "objects", 0, "colour"), "red"),
        (("furniture", "objects", 0, "at"), "here"),
        (("lights",), {"lamps": {"ceiling": {"lumen": 1}}}),
        (("seed",), -1),
        (("cameras",), {"from": "nowhere"}),
    ],
)
def test_a_mistake_in_data_is_said_in_the_words_of_a_file(
    path: tuple[str | int, ...], value: Any
) -> None:
    data = wrong(path, value)
    with pytest.raises(DescriptionError) as of_file:
        parse_room(yaml.safe_dump(data, sort_keys=False))
    for make in (room_of, lambda data: Room(**data)):
        with pytest.raises(DescriptionError) as of_data:
            make(data)
        # The same lines, but for where they stand: name:line:column.
        said = [line.partition("room.yaml:")[2] for line in of_file.value.message.splitlines()[1:]]
        words = [line.split(": ", 1)[1] for line in said]
        assert [line.strip() for line in of_data.value.message.splitlines()[1:]] == words
        assert of_data.value.place == "the room"


def test_mistakes_come_in_the_order_of_the_data() -> None:
    rows = [{"category": "chair", "at": [1, 2], "size": "big"} for _ in range(12)]
    with pytest.raises(DescriptionError) as refused:
        room_of({**DATA, "furniture": {"objects": rows}, "seed": -1})
    lines = refused.value.message.splitlines()[1:]
    assert [line.split("[")[1].split("]")[0] for line in lines[:12]] == [str(i) for i in range(12)]
    assert lines[12].strip().startswith("seed: ")


@pytest.mark.parametrize("data", [[1], "room", None, {1: "office"}])
def test_what_is_no_description_is_refused(data: Any) -> None:
    with pytest.raises(DescriptionError, match=r"expected keys|must be text"):
        room_of(data)


def test_data_that_holds_itself_is_refused() -> None:
    data: dict[str, Any] = {}
    data["layout"] = data
    with pytest.raises(DescriptionError, match="nested more than"):
        room_of(data)


def test_a_room_knows_the_folder_of_its_file(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text(yaml.safe_dump(DATA))
    assert load_room(tmp_path / "room.yaml").folder == tmp_path
    assert room_of(DATA).folder is None
    assert room_of(DATA).located(tmp_path).as_dict() == room_of(DATA).as_dict()
