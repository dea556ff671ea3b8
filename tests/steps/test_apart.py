"""Captured objects that were built into each other come apart, by as little as it takes."""

import numpy as np
import pytest

from openrooms_usd.geometry.solids import box
from openrooms_usd.library.assets import Asset, Model
from openrooms_usd.steps.alignment.apart import moved_apart
from openrooms_usd.steps.alignment.placement import Placement
from openrooms_usd.steps.alignment.surroundings import RoomGeometry

CORNERS = np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [0.0, 4.0]])
ROOM = RoomGeometry(0.0, 2.5, np.stack([CORNERS, np.roll(CORNERS, -1, axis=0)], axis=1))


def item(
    name: str,
    x: float,
    y: float,
    size: tuple[float, float, float] = (1.0, 1.0, 0.8),
    z: float | None = None,
    yaw: float = 0.0,
) -> Placement:
    asset = Asset("thing", (name,), lambda: Model({"body": box(size, (0.0, 0.0, 0.5 * size[2]))}))
    return Placement(name, asset, size, x, y, z, yaw)


def test_what_is_in_another_is_moved_out_and_that_is_told() -> None:
    notes: list[str] = []
    table, away = moved_apart([item("table", 2.0, 2.0), item("away", 4.0, 1.0)], ROOM, notes)
    assert (table.x, away.x) == (2.0, 4.0)
    assert not notes
    chair = item("chair", 2.6, 2.0, (0.4, 0.4, 0.9))
    table, lamp, chair, away = moved_apart(
        [
            item("table", 2.0, 2.0),
            item("lamp", 2.0, 2.0, (0.2, 0.2, 0.2), 0.8),
            chair,
            item("away", 4.0, 1.0),
        ],
        ROOM,
        notes,
    )
    # It was 10 cm deep; the lighter one gives way more, and what stands on the other follows it.
    assert chair.x - table.x == pytest.approx(0.7, abs=0.003)
    assert chair.x - 2.6 > 2.0 - table.x > 0.0
    assert lamp.x == pytest.approx(table.x, abs=1e-6)
    assert (away.x, away.y) == (4.0, 1.0)
    assert len(notes) == 1 and "chair the farthest" in notes[0]


def test_what_is_in_a_wall_is_moved_out_of_it() -> None:
    thing, _ = moved_apart([item("thing", 0.4, 2.0), item("away", 4.0, 1.0)], ROOM, [])
    assert thing.x == pytest.approx(0.5, abs=0.003)


def test_what_nobody_can_part_stays_within_reach() -> None:
    one, other = moved_apart([item("one", 2.0, 2.0), item("other", 2.01, 2.0)], ROOM, [])
    assert max(abs(one.x - 2.0), abs(other.x - 2.01), abs(one.y - 2.0), abs(other.y - 2.0)) < 0.36


def test_without_walls_nothing_is_moved() -> None:
    things = [item("one", 2.0, 2.0), item("other", 2.3, 2.0)]
    assert moved_apart(things, RoomGeometry(), []) == things
