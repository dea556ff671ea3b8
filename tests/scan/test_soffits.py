"""Soffits and beams hang in a room and do not bound it; tops of wardrobes are no ceilings."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import surfels
from openrooms_usd.scan.rooms.faces import no_walls
from openrooms_usd.scan.rooms.layout import find_layout
from openrooms_usd.scan.rooms.levelling import level
from openrooms_usd.scan.rooms.soffits import NO_CEILINGS, ceilings_of
from tests.scan.scanned_rooms import RoomScan, corner_error

SQUARE = ((0.0, 0.0), (4.2, 0.0), (4.2, 3.1), (0.0, 3.1))
HEIGHT, UNDERSIDE = 2.7, 2.25


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
