"""Storeys are told apart by their floors, and never mixed in one plan."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import surfels
from openrooms_usd.scan.reconstruction import find_rooms
from openrooms_usd.scan.rooms.layout import LayoutOptions
from openrooms_usd.scan.rooms.storeys import storeys
from tests.scan.scanned_rooms import RoomScan, corner_error

SMALL = ((0.0, 0.0), (4.2, 0.0), (4.2, 3.1), (0.0, 3.1))
LARGE = ((-0.6, -0.4), (5.4, -0.4), (5.4, 3.6), (-0.6, 3.6))
RISE = 2.8


def house(lower: tuple[tuple[float, float], ...], upper: tuple[tuple[float, float], ...]) -> Cloud:
    below, above = RoomScan(lower).cloud().points, RoomScan(upper).cloud(1).points
    return Cloud(np.concatenate([below, above + np.array([0.0, 0.0, RISE])]))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("larger", ["below", "above"])
def test_the_larger_of_two_storeys_is_taken_alone(larger: str):
    cloud = house(LARGE, SMALL) if larger == "below" else house(SMALL, LARGE)
    found = find_rooms(cloud)
    (room,) = found.rooms
    back = room.moved(found.level.scan_from_level).corners
    assert corner_error(back[:, :2], np.array(LARGE)) < 0.05
    assert back[:, 2] == pytest.approx(0.0 if larger == "below" else RISE, abs=0.02)
    assert room.ceiling == pytest.approx(2.5, abs=0.02)
    assert any("2 storeys" in note and "`storey: 0` to `1`" in note for note in found.notes)
    assert np.ptp(found.cloud.points[:, 2]) < 2.9


@pytest.mark.one_in(2)
@pytest.mark.parametrize("storey", [0, 1])
def test_another_storey_is_taken_where_that_is_asked(storey: int):
    found = find_rooms(house(LARGE, SMALL), LayoutOptions(storey=storey))
    (room,) = found.rooms
    back = room.moved(found.level.scan_from_level).corners
    assert corner_error(back[:, :2], np.array((LARGE, SMALL)[storey])) < 0.05
    assert back[:, 2] == pytest.approx(RISE * storey, abs=0.02)
    assert any("as asked" in note for note in found.notes)


def test_a_lower_ceiling_is_no_storey():
    hall, side = RoomScan(LARGE, height=4.5).cloud().points, RoomScan(SMALL).cloud(1).points
    both = surfels(Cloud(np.concatenate([hall, side + np.array([6.2, 0.0, 0.0])])))
    assert len(storeys(both)) == 1
    assert len(storeys(surfels(RoomScan(SMALL).cloud()))) == 1
