"""Leaves of doors that were opened against a wall are no doors in it."""

from openrooms_usd.scan.openings.detection import find_openings
from tests.scan.walled_rooms import CORNERS, DOOR, HEIGHT, Sheet, room

DOORWAY = Sheet(0, (2.5, 3.4), (0.0, 2.1))


def leaf(before: float) -> list[Sheet]:
    """A leaf beside the doorway, so far before the pier."""
    return [Sheet(0, (1.5, 2.4), (0.0, 2.1), -before, DOOR)]


def test_a_leaf_opened_against_the_pier_is_no_door_there() -> None:
    found = find_openings(room([DOORWAY, *leaf(0.16)]), CORNERS, HEIGHT)
    assert len(found) == 1
    (door,) = found
    along = abs(door.corners[1, 0] - door.corners[0, 0])
    assert door.type == "door" and abs(along - 0.9) < 0.15


def test_a_closed_leaf_in_its_wall_is_a_door() -> None:
    found = find_openings(room([DOORWAY, *leaf(0.02)]), CORNERS, HEIGHT)
    assert [door.type for door in found] == ["door", "door"]
