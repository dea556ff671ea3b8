"""Rooms end at walls: not where little was seen, nor at what stands or hangs free."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import surfels
from openrooms_usd.scan.rooms.borders import moved_behind
from openrooms_usd.scan.rooms.layout import find_layout
from openrooms_usd.scan.rooms.levelling import level
from openrooms_usd.scan.rooms.outline import outline_of
from openrooms_usd.scan.rooms.spaces import _rooms, _watershed
from tests.scan.scanned_rooms import RoomScan, corner_error

SQUARE = ((0.0, 0.0), (4.2, 0.0), (4.2, 3.1), (0.0, 3.1))


def found(cloud: Cloud) -> list[np.ndarray]:
    stand = level(cloud)
    rooms = find_layout(cloud.moved(stand.level_from_scan), stand)
    return [room.found(stand).corners[:, :2] for room in rooms]


def plan(*walls: tuple[slice, slice]) -> np.ndarray:
    """(60, 100) barriers of 5 cm around 3 x 5 m, and some within."""
    barrier = np.zeros((60, 100), bool)
    barrier[[0, -1]] = barrier[:, [0, -1]] = True
    for rows in walls:
        barrier[rows] = True
    return barrier


def test_a_wall_with_a_door_parts_rooms_and_columns_do_not():
    wall = plan((slice(0, 24), slice(50, 52)), (slice(40, 60), slice(50, 52)))
    rooms, count = _rooms(~wall, wall)
    assert count == 2
    assert (rooms[:, 5:48][~wall[:, 5:48]] == rooms[30, 25]).all()
    assert (rooms[:, 54:95][~wall[:, 54:95]] == rooms[30, 75]).all()
    columns = plan((slice(15, 28), slice(48, 52)), (slice(34, 46), slice(48, 52)))
    assert _rooms(~columns, columns)[1] == 1


def test_what_was_not_seen_does_not_part_rooms():
    walls = plan()
    free = ~walls
    free[18:, 45:60] = False
    rooms, count = _rooms(free, walls)
    assert count == 1
    assert (rooms[free] == 1).all()


def test_pixels_go_where_the_way_is_widest():
    x = np.linspace(0.0, 1.0, 41)
    width = np.minimum(0.2 + np.abs(x - 0.6), 0.5)[:, None] * np.ones(9)
    markers = np.zeros((41, 9), np.int32)
    markers[0, 4], markers[-1, 4] = 1, 2
    flooded = _watershed(width, markers, 2)
    assert (flooded[x < 0.59] == 1).all()
    assert (flooded[x > 0.61] == 2).all()


def test_a_lamp_below_the_ceiling_leaves_the_room_whole():
    lamp = ((1.95, 1.4, 0.3, 0.3, 2.1, 2.5),)
    cloud = RoomScan(SQUARE, boxes=lamp).cloud()
    (corners,) = found(Cloud(cloud.points))
    assert corner_error(corners, np.array(SQUARE)) < 0.04


@pytest.mark.slow
def test_a_wall_that_was_missed_stands_behind_the_floor_that_ends_in_waves():
    cloud = RoomScan(SQUARE, missing=(1,)).cloud()
    end = 4.2 - 0.04 - 0.25 * np.abs(np.sin(3.0 * cloud.points[:, 1]))
    pieces = surfels(cloud.take(cloud.points[:, 0] < end))
    near = outline_of(np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.1), (0.0, 3.1)]))
    unseen = near.normals[:, 0] > 0.9
    moved = moved_behind(near, unseen, pieces)
    assert abs(float(moved.offsets[unseen][0]) - 4.2) < 0.08
    np.testing.assert_array_equal(moved.offsets[~unseen], near.offsets[~unseen])
    (corners,) = found(cloud.take(cloud.points[:, 0] < end))
    assert corner_error(corners, np.array(SQUARE)) < 0.1
