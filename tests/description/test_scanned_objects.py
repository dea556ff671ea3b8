"""Hints about the objects of a scan: what carries them must be there, and end on the floor."""

from typing import Any

import pytest

from openrooms_usd.description import parse_room
from openrooms_usd.errors import DescriptionError


def text(*supports: Any) -> str:
    rows = "\n".join(
        f"    - {{instance: {number}, support: {support}}}"
        for number, support in enumerate(supports, 1)
    )
    return f"layout: {{from: scan, scan: a.ply}}\nfurniture:\n  from: scan\n  objects:\n{rows}\n"


def mistakes(*supports: Any) -> list[str]:
    with pytest.raises(DescriptionError) as caught:
        parse_room(text(*supports), "room.yaml")
    return [line.strip() for line in str(caught.value).splitlines() if "furniture" in line]


def test_supports_are_words_or_instances() -> None:
    room = parse_room(text("floor", 1, "wall", "ceiling", 2, "null"))
    objects: Any = room.furniture.objects
    assert [thing.support for thing in objects] == ["floor", 1, "wall", "ceiling", 2, None]


def test_an_instance_that_is_not_hinted_has_a_place() -> None:
    assert mistakes("floor", 7) == [
        "room.yaml:6:30: furniture.objects[1].support: no object of this list has the instance 7"
    ]


@pytest.mark.parametrize("supports", [(1,), (2, 1), (2, 3, 1)])
def test_circles_are_refused(supports: tuple[int, ...]) -> None:
    found = mistakes(*supports, "floor", 1)
    # What stands on the circle without being part of it is not to blame.
    assert [row.split(": ", 2)[1:] for row in found] == [
        [
            f"furniture.objects[{row}].support",
            "depends on itself; one object must stand on the floor",
        ]
        for row in range(len(supports))
    ]


@pytest.mark.parametrize("support", ["table", "0", "-1", "1.5", "[1]", "true"])
def test_nothing_else_carries(support: str) -> None:
    assert any("furniture.objects[0].support" in row for row in mistakes(support))
