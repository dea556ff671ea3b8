"""Floor, gravity and directions of rooms whose frame is known."""

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import fit_plane, surfels, total_least_squares
from openrooms_usd.scan.reconstruction import find_rooms
from openrooms_usd.scan.rooms.layout import LayoutOptions
from openrooms_usd.scan.rooms.levelling import Level, level
from openrooms_usd.scan.rooms.storeys import storeys
from tests.scan.scanned_rooms import SQUARE, RoomScan, corner_error, motion

ROOM = RoomScan(SQUARE, boxes=((1.0, 0.5, 1.4, 0.7, 0.70, 0.74), (0.0, 2.4, 1.2, 0.6, 0.0, 2.1)))
UP = np.array([0.0, 0.0, 1.0])
LARGE = ((-0.6, -0.4), (5.4, -0.4), (5.4, 3.6), (-0.6, 3.6))
RISE = 2.8


def assert_floor(found: Level, matrix: np.ndarray, degrees: float = 0.2, metres: float = 0.01):
    normal, middle = matrix[:3, 2], matrix[:3, :3] @ [2.1, 1.5, 0.0] + matrix[:3, 3]
    assert np.rad2deg(np.arccos(min(1.0, found.normal @ normal))) < degrees
    assert abs((middle - found.point) @ found.normal) < metres


@pytest.mark.parametrize("tilt", [0.0, 4.0, 10.0])
def test_floor_of_a_tilted_room_far_from_the_origin(tilt):
    matrix = motion(tilt, 33.0, (4e5, 5.6e6, 120.0))
    found = level(ROOM.cloud().moved(matrix))
    assert_floor(found, matrix)
    assert found.floor_seen
    assert found.ceiling == pytest.approx(2.5, abs=0.01)


def test_given_up_of_another_axis_five_degrees_off():
    matrix = motion(0.0, 20.0, (0.0, 0.0, 0.0))
    lying = np.eye(4)
    lying[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    up = motion(5.0, 0.0, (0, 0, 0))[:3, :3] @ (lying @ matrix)[:3, 2]
    found = level(ROOM.cloud().moved(lying @ matrix), up)
    assert_floor(found, lying @ matrix)


def test_the_level_frame_is_rigid_and_aligned():
    cloud = ROOM.cloud().moved(motion(7.0, 61.0, (1e6, -1e6, 3.0)))
    found = level(cloud)
    turn = found.level_from_scan[:3, :3]
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    np.testing.assert_allclose(found.level_from_scan @ found.scan_from_level, np.eye(4), atol=1e-8)
    moved = cloud.moved(found.level_from_scan).points
    assert np.abs(moved).max() < 6.0
    walls = moved[(moved[:, 2] > 0.3) & (cloud.label == 1)]
    assert found.directions[0] == pytest.approx(0.0, abs=1e-9)
    # The walls of a rectangle lie on its borders, which run along the frame's axes.
    low, high = np.quantile(walls[:, :2], (0.002, 0.998), axis=0)
    border = np.minimum(np.abs(walls[:, :2] - low), np.abs(walls[:, :2] - high)).min(axis=1)
    assert np.quantile(border, 0.99) < 0.03


def test_no_floor_is_said_and_taken_from_the_walls():
    room = RoomScan(SQUARE, floor=False, ceiling=False)
    matrix = motion(3.0, 10.0, (0.0, 0.0, 0.0))
    found = level(room.cloud().moved(matrix))
    assert not found.floor_seen
    assert found.notes
    assert np.isnan(found.residual)
    assert_floor(found, matrix, degrees=0.3, metres=0.06)


def test_a_floor_of_which_a_quarter_is_seen_is_the_floor_and_no_table():
    cloud = RoomScan(SQUARE, boxes=((0.5, 0.5, 2.0, 1.5, 0.70, 0.74),)).cloud()
    hidden = (cloud.label == 2) & (cloud.points[:, 0] > 1.05)
    assert_floor(level(cloud.take(~hidden)), np.eye(4), metres=0.015)


def test_dense_half_does_not_tilt_the_floor():
    cloud = ROOM.cloud()
    rng = np.random.default_rng(1)
    sparse = (cloud.points[:, 0] < 2.0) | (rng.random(len(cloud)) < 0.05)
    dense = RoomScan(SQUARE, spacing=0.012, ceiling=False).cloud()
    half = dense.points[:, 0] < 2.0
    mixed = Cloud(np.concatenate([cloud.points[sparse], dense.points[half]]))
    assert_floor(level(mixed), np.eye(4))


@pytest.mark.slow
def test_thirty_percent_outliers():
    cloud = ROOM.cloud()
    rng = np.random.default_rng(2)
    stray = rng.uniform((-1.0, -1.0, -1.0), (5.0, 4.0, 3.5), (int(0.43 * len(cloud)), 3))
    assert_floor(level(Cloud(np.concatenate([cloud.points, stray]))), np.eye(4))


def test_sloping_walls_directions_of_two_frames():
    corners = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (1.2, 4.2), (0.0, 1.4))
    found = level(RoomScan(corners).cloud())
    assert len(found.directions) >= 2
    assert all(0.0 <= angle < 90.0 for angle in found.directions)


@pytest.mark.parametrize("count", [0, 1, 50])
def test_too_few_points(count):
    with pytest.raises(InputError, match="points") as caught:
        level(Cloud(np.random.default_rng(0).random((count, 3))))
    assert caught.value.remedy


def test_equal_input_gives_equal_bits():
    cloud = ROOM.cloud()
    first, second = level(cloud), level(cloud)
    np.testing.assert_array_equal(first.level_from_scan, second.level_from_scan)


def test_plane_among_outliers_is_the_plane():
    rng = np.random.default_rng(3)
    normal = np.array([0.03, -0.02, 1.0]) / np.linalg.norm([0.03, -0.02, 1.0])
    plan = rng.uniform(-2.0, 2.0, (3000, 2))
    z = 0.4 - (plan @ normal[:2]) / normal[2] + 0.003 * rng.normal(size=3000)
    stray = rng.uniform(-2.0, 2.0, (2000, 3))
    points = np.concatenate([np.column_stack([plan, z]), stray])
    found = fit_plane(points, np.array([0.0, 0.0, 1.0]), 0.03, 10.0)
    assert found is not None
    assert np.rad2deg(np.arccos(found.normal @ normal)) < 0.05
    assert found.residual < 0.006
    assert abs(found.heights(np.array([[0.0, 0.0, 0.4]]))[0]) < 0.001


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
    assert any("uneven" in note for note in level(steps(RoomScan(SQUARE).cloud(), 0.08)).notes)
    assert level(RoomScan(SQUARE).cloud()).notes == ()


def test_a_flat_floor_keeps_its_own_plane():
    found = level(RoomScan(SQUARE, boxes=((1.0, 0.5, 1.4, 0.7, 0.70, 0.74),)).cloud())
    assert degrees(found.normal) < 0.03
    assert found.residual < 0.01


def house(lower: tuple[tuple[float, float], ...], upper: tuple[tuple[float, float], ...]) -> Cloud:
    below, above = RoomScan(lower).cloud().points, RoomScan(upper).cloud(1).points
    return Cloud(np.concatenate([below, above + np.array([0.0, 0.0, RISE])]))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("larger", ["below", "above"])
def test_the_larger_of_two_storeys_is_taken_alone(larger: str):
    cloud = house(LARGE, SQUARE) if larger == "below" else house(SQUARE, LARGE)
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
    found = find_rooms(house(LARGE, SQUARE), LayoutOptions(storey=storey))
    (room,) = found.rooms
    back = room.moved(found.level.scan_from_level).corners
    assert corner_error(back[:, :2], np.array((LARGE, SQUARE)[storey])) < 0.05
    assert back[:, 2] == pytest.approx(RISE * storey, abs=0.02)
    assert any("as asked" in note for note in found.notes)


def test_a_lower_ceiling_is_no_storey():
    hall, side = RoomScan(LARGE, height=4.5).cloud().points, RoomScan(SQUARE).cloud(1).points
    both = surfels(Cloud(np.concatenate([hall, side + np.array([6.2, 0.0, 0.0])])))
    assert len(storeys(both)) == 1
    assert len(storeys(surfels(RoomScan(SQUARE).cloud()))) == 1
