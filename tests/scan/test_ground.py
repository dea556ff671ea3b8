"""The floor of scans whose poses drifted: bent in place, but true in what it faces."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.planes import total_least_squares
from openrooms_usd.scan.rooms.levelling import level
from tests.scan.scanned_rooms import RoomScan

SQUARE = ((0.0, 0.0), (4.2, 0.0), (4.2, 3.1), (0.0, 3.1))
UP = np.array([0.0, 0.0, 1.0])


def degrees(normal: np.ndarray) -> float:
    return float(np.rad2deg(np.arccos(min(1.0, abs(normal @ UP)))))


def steps(cloud: Cloud, rise: float) -> Cloud:
    """Each quarter of the room as high as the scanner took itself to be when it stood there."""
    quarter = np.floor(cloud.points[:, 0] / 1.05)
    heights = rise * np.array([-0.5, 0.1, -0.1, 0.5])
    points = cloud.points.copy()
    points[:, 2] += heights[np.clip(quarter, 0, 3).astype(int)]
    return Cloud(points, label=cloud.label)


@pytest.mark.parametrize("rise", [0.03, 0.08])
def test_a_floor_that_drift_bent_is_level_at_its_mean_height(rise):
    cloud = steps(RoomScan(SQUARE).cloud(), rise)
    floor = cloud.points[cloud.label == 2]
    leaning, _ = total_least_squares(floor, np.ones(len(floor)), UP)
    assert degrees(leaning) > 0.3
    found = level(cloud)
    assert degrees(found.normal) < 0.2
    assert abs((np.array([2.1, 1.55, 0.0]) - found.point) @ found.normal) < 0.01
    assert found.residual > 0.2 * rise


def test_a_bent_floor_is_said_to_be_bent():
    assert any("bent" in note for note in level(steps(RoomScan(SQUARE).cloud(), 0.08)).notes)
    assert level(RoomScan(SQUARE).cloud()).notes == ()


def test_a_flat_floor_keeps_its_own_plane():
    found = level(RoomScan(SQUARE, boxes=((1.0, 0.5, 1.4, 0.7, 0.70, 0.74),)).cloud())
    assert degrees(found.normal) < 0.03
    assert found.residual < 0.01
