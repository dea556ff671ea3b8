"""``relative_to`` in a description: names that exist, and no circle over it and ``on``."""

from typing import Any

import pytest

from openrooms_usd.description import parse_room
from openrooms_usd.errors import DescriptionError


def text(*objects: str) -> str:
    rows = "\n".join(f"    - {{{row}, category: table, at: [1, 1]}}" for row in objects)
    return f"furniture:\n  objects:\n{rows}\n"


def mistakes(*objects: str) -> list[str]:
    with pytest.raises(DescriptionError) as caught:
        parse_room(text(*objects), "room.yaml")
    return [line.strip() for line in str(caught.value).splitlines() if "furniture" in line]


def test_any_object_may_be_the_frame_of_others() -> None:
    room = parse_room(text("name: a, relative_to: table_2, on: wall", "name: b, on: a", "yaw: 3"))
    objects: Any = room.furniture.objects
    assert objects[0].relative_to == "table_2"


def test_unknown_names_have_a_place_and_a_hint() -> None:
    assert mistakes("name: sofa", "relative_to: soffa", "relative_to: floor") == [
        "room.yaml:4:21: furniture.objects[1].relative_to: no object is named 'soffa' "
        "(did you mean 'sofa'?); allowed: the name of another object",
        "room.yaml:5:21: furniture.objects[2].relative_to: no object is named 'floor'; "
        "allowed: the name of another object",
    ]


def test_the_room_s_own_names_are_taken() -> None:
    assert "'wall' is a reserved name" in mistakes("name: wall")[0]


def test_circles_may_go_over_both_keys() -> None:
    found = mistakes(
        "name: a, on: b",
        "name: b, relative_to: c",
        "name: c, on: a",
        "name: d, relative_to: d",
        "name: e, on: a, relative_to: f",
        "name: f",
    )
    assert [row.split(": ", 2)[1:] for row in found] == [
        ["furniture.objects[0].on", f"'a' on 'b' {CIRCLE}"],
        ["furniture.objects[1].relative_to", f"'b' relative to 'c' {CIRCLE}"],
        ["furniture.objects[2].on", f"'c' on 'a' {CIRCLE}"],
        ["furniture.objects[3].relative_to", "'d' cannot be relative to itself"],
    ]


CIRCLE = "depends on itself; one object must stand on the floor"


def test_ten_thousand_links_are_checked_in_one_walk() -> None:
    rows = [f"name: o{i}, on: o{i + 1}, relative_to: o{i + 2}" for i in range(3000)]
    room = parse_room(text(*rows, "name: o3000", "name: o3001"))
    assert len(room.furniture.objects) == 3002
