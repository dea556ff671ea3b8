"""Walls of which a scan shows little: blocks, directions of noisy walls, walls behind furniture."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import surfels
from openrooms_usd.scan.rooms.directions import angle_between, wall_directions
from openrooms_usd.scan.rooms.layout import find_layout
from openrooms_usd.scan.rooms.levelling import level
from openrooms_usd.scan.rooms.outline import outline_of
from openrooms_usd.scan.rooms.refit import refitted
from openrooms_usd.scan.rooms.walls import upright
from tests.scan.scanned_rooms import RoomScan, corner_error, motion

SQUARE = ((0.0, 0.0), (4.2, 0.0), (4.2, 3.1), (0.0, 3.1))
# A block of 1 x 1.3 m stands out from the wall at x = 4.
BLOCK = (
    (0.0, 0.0),
    (4.0, 0.0),
    (4.0, 2.0),
    (2.7, 2.0),
    (2.7, 3.0),
    (4.0, 3.0),
    (4.0, 5.0),
    (0, 5.0),
)


def found(cloud: Cloud) -> list[np.ndarray]:
    stand = level(cloud)
    rooms = find_layout(cloud.moved(stand.level_from_scan), stand)
    return [room.found(stand).corners[:, :2] for room in rooms]


@pytest.mark.slow
def test_a_block_whose_side_nobody_saw_is_no_floor():
    scan = RoomScan(BLOCK, missing=(2,), boxes=((3.1, 1.2, 0.7, 0.6, 0.0, 0.9),))
    cloud = scan.cloud()
    # Nothing of the floor and ceiling is seen where furniture beside the block hides them.
    x, y, z = cloud.points.T
    hidden = (x > 2.9) & (y > 1.3) & (y < 2.0) & (z < 0.05)
    (corners,) = found(cloud.take(~hidden))
    assert corner_error(corners, np.array(BLOCK)) < 0.06


def test_a_column_that_stands_free_before_a_wall_is_no_block():
    column = ((2.0, 1.0, 0.5, 0.5, 0.0, 2.5),)
    (corners,) = found(Cloud(RoomScan(SQUARE, boxes=column).cloud().points))
    assert corner_error(corners, np.array(SQUARE)) < 0.06


@pytest.mark.parametrize("yaw", [8.0, 21.0, 37.0])
def test_directions_of_noisy_walls_are_those_of_their_places(yaw):
    cloud = RoomScan(SQUARE, spacing=0.025, noise=0.02).cloud().moved(motion(0.0, yaw, (3, 1, 0)))
    assert float(angle_between(wall_directions(surfels(cloud))[0], yaw)) < 0.15


def test_a_wall_of_which_strays_were_seen_keeps_its_direction():
    hall = ((0.0, 0.0), (4.2, 0.0), (4.2, 5.1), (0.0, 5.1))
    cloud = RoomScan(hall, missing=(1,)).cloud()
    y, z = (axis.ravel() for axis in np.meshgrid(np.arange(1.2, 2.0, 0.02), np.arange(0, 2, 0.02)))
    strays = np.column_stack([4.2 - 0.05 * (y - 1.2), y, z])
    points = np.concatenate([cloud.points, strays])
    outline = outline_of(np.array(hall))
    moved = refitted(outline, upright(surfels(Cloud(points))), (0.0,))
    np.testing.assert_allclose(moved.normals[1], outline.normals[1], atol=0.004)


def test_a_wall_that_was_seen_in_part_is_where_it_was_seen():
    cloud = RoomScan(SQUARE).cloud()
    x, y, z = cloud.points.T
    # Only 0.7 m of the wall at x = 4.2, and strays behind it.
    kept = (x < 4.15) | ((y > 1.2) & (y < 1.9)) | (z < 0.02) | (z > 2.48)
    strays = cloud.points[(x > 3.9) & (z < 0.05)] + [0.12, 0.0, 0.0]
    points = np.concatenate([cloud.points[kept], strays])
    (corners,) = found(Cloud(points))
    assert corner_error(corners, np.array(SQUARE)) < 0.05
