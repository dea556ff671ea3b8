"""What is indoors: all that a ceiling covers which ends at walls; other ceilings say nothing."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import Surfels, surfels
from openrooms_usd.scan.rooms.layout import find_layout
from openrooms_usd.scan.rooms.levelling import level
from openrooms_usd.scan.rooms.occupancy import PIXEL_M
from openrooms_usd.scan.rooms.roofs import roofed
from openrooms_usd.scan.rooms.spaces import find_spaces, walled_shares
from openrooms_usd.scan.rooms.walls import upright
from tests.scan.scanned_rooms import RoomScan, corner_error

HALL = ((0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0))
GATE = (1, 0.8, 3.6, 0.0, 2.6)


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
