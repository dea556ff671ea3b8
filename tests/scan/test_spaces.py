"""Rooms end at walls: not where little was seen, nor at what stands or hangs free."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import Surfels, surfels
from openrooms_usd.scan.rooms.candidates import moved_behind
from openrooms_usd.scan.rooms.ceilings import NO_CEILINGS, ceilings_of
from openrooms_usd.scan.rooms.faces import no_walls
from openrooms_usd.scan.rooms.layout import find_layout
from openrooms_usd.scan.rooms.levelling import level
from openrooms_usd.scan.rooms.outline import outline_of
from openrooms_usd.scan.rooms.spaces import (
    PIXEL_M,
    _rooms,
    _watershed,
    find_spaces,
    roofed,
    walled_shares,
)
from openrooms_usd.scan.rooms.walls import upright
from tests.scan.scanned_rooms import SQUARE, RoomScan, corner_error, rings_found

HEIGHT, UNDERSIDE = 2.7, 2.25
HALL = ((0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0))
GATE = (1, 0.8, 3.6, 0.0, 2.6)


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
    (corners,) = rings_found(Cloud(cloud.points))
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
    (corners,) = rings_found(cloud.take(cloud.points[:, 0] < end))
    assert corner_error(corners, np.array(SQUARE)) < 0.1


def with_soffit(depth: float) -> Cloud:
    """A room whose ceiling is lower along its wall at y = 3.1 m."""
    cloud = RoomScan(SQUARE, height=HEIGHT).cloud()
    rng = np.random.default_rng(6)
    edge = 3.1 - depth
    _, y, z = cloud.points.T
    hidden = (y > edge + 0.02) & (z > UNDERSIDE + 0.02)
    room = cloud.points[~hidden]
    count = int(4.2 * (HEIGHT - UNDERSIDE) / 0.035**2)
    face = rng.uniform((0.0, edge, UNDERSIDE), (4.2, edge, HEIGHT), (count, 3))
    count = int(4.2 * depth / 0.035**2)
    underside = rng.uniform((0.0, edge, UNDERSIDE), (4.2, 3.1, UNDERSIDE), (count, 3))
    points = np.concatenate([room, face, underside])
    return Cloud(points + 0.003 * rng.normal(size=points.shape))


@pytest.mark.parametrize("depth", [0.5, 0.18])
def test_a_room_goes_on_below_a_soffit(depth: float):
    cloud = with_soffit(depth)
    stand = level(cloud)
    (room,) = find_layout(cloud.moved(stand.level_from_scan), stand)
    assert corner_error(room.found(stand).corners[:, :2], np.array(SQUARE)) < 0.05


def test_the_face_of_a_soffit_hangs_and_the_walls_do_not():
    pieces = surfels(with_soffit(0.5))
    hanging, standing = no_walls(pieces, ceilings_of(pieces))
    upright = np.abs(pieces.normals[:, 2]) < 0.25
    x, y, z = pieces.points.T
    face = upright & (np.abs(y - 2.6) < 0.04) & (z > 2.35) & (z < 2.6) & (x > 0.3) & (x < 3.9)
    assert hanging[face].mean() > 0.9
    walls = upright & ((y < 0.04) | (x < 0.04) | (x > 4.16) | (y > 3.06)) & (np.abs(y - 2.6) > 0.1)
    assert (hanging | standing)[walls].mean() < 0.02


def test_heights_are_those_of_the_ceiling_above():
    ceilings = ceilings_of(surfels(with_soffit(0.5)))
    found = ceilings.above(np.array([(2.0, 1.0), (2.0, 2.9), (20.0, 1.0)]))
    assert found[:2] == pytest.approx([HEIGHT, UNDERSIDE], abs=0.03)
    assert np.isinf(found[2])


def test_the_top_of_a_wardrobe_is_no_ceiling():
    wardrobe = ((0.02, 1.0, 0.6, 1.6, 0.0, 2.1),)
    scan = RoomScan(SQUARE, boxes=wardrobe, ceiling=False).cloud()
    x, y, _ = scan.points.T
    below = (x < 0.6) & (y > 1.05) & (y < 2.55) & (scan.points[:, 2] < 0.05)
    assert ceilings_of(surfels(scan.take(~below))) is NO_CEILINGS


def ceiling(x: float) -> tuple[Surfels, np.ndarray]:
    """A ceiling of 4 x 3 m that was seen up to x, and the walls around."""
    places = np.stack(np.meshgrid(np.arange(0.0, 4.0, 0.05), np.arange(0.0, 3.0, 0.05)), -1)
    plan = places.reshape(-1, 2) + 0.025
    plan = plan[plan[:, 0] < x]
    points = np.column_stack([plan, np.full(len(plan), 2.5)])
    normals = np.tile([0.0, 0.0, -1.0], (len(points), 1))
    pieces = Surfels(points, normals, np.zeros(len(points)), np.ones(len(points)))
    barrier = np.zeros((100, 80), bool)
    barrier[10:91, [10, 70]] = True
    barrier[[10, 90], 10:71] = True
    return pieces, barrier


@pytest.mark.parametrize(("x", "whole"), [(4.0, True), (2.4, False)])
def test_a_ceiling_covers_its_room_where_it_ends_at_walls(x: float, whole: bool):
    pieces, barrier = ceiling(x)
    roof = roofed(pieces, barrier, np.full(2, -10 * PIXEL_M))
    assert roof[40, 40]
    assert roof[2, 2] == (not whole)


def yard() -> Cloud:
    """Ground before the gate of a hall, wider than the hall."""
    rng = np.random.default_rng(2)
    plan = rng.uniform((6.2, -4.0), (16.0, 8.0), (60_000, 2))
    seen = np.abs(plan[:, 1] - 2.2) < 0.2 + 0.5 * (plan[:, 0] - 5.0)
    ground = np.column_stack([plan, np.zeros(len(plan))])[seen]
    return Cloud(ground, label=np.full(len(ground), 2, np.int32))


def test_a_lawn_is_beside_no_walls_and_a_room_is():
    room = RoomScan(HALL, missing=(1, 2)).cloud()
    rng = np.random.default_rng(4)
    plan = rng.uniform((20.0, 0.0), (24.0, 4.0), (20_000, 2))
    lawn = np.column_stack([plan, np.zeros(len(plan))])
    pieces = surfels(Cloud(np.concatenate([room.points, lawn])))
    walls = upright(pieces)
    spaces = find_spaces(pieces, walls)
    shares = walled_shares(spaces, walls)
    inside, outside = spaces.numbers(np.array([(3.0, 2.0), (22.0, 2.0)]))
    assert shares[inside] > 0.3
    assert shares[outside] == 0.0


@pytest.mark.slow
def test_a_yard_seen_through_an_open_gate_is_no_part_of_the_hall():
    hall = RoomScan(HALL, height=3.2, holes=(GATE,)).cloud()
    outside = yard()
    both = Cloud(np.concatenate([hall.points, outside.points]))
    stand = level(both)
    room, *_ = find_layout(both.moved(stand.level_from_scan), stand)
    assert corner_error(room.found(stand).corners[:, :2], np.array(HALL)) < 0.05
