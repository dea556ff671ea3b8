"""Rooms of exactly known corners, seen by points: what is found, what is guessed, what is left."""

import numpy as np
import pytest
import shapely

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import find_rooms
from openrooms_usd.scan.rooms.layout import LayoutOptions, LayoutRoom, find_layout
from openrooms_usd.scan.rooms.levelling import level
from openrooms_usd.scan.rooms.spaces import free_along_rays
from tests.scan.scanned_rooms import SQUARE, RoomScan, corner_error, motion

FURNITURE = ((1.0, 0.6, 1.4, 0.8, 0.70, 0.74), (0.02, 1.3, 0.6, 1.2, 0.0, 2.0))
ROOMS = {
    "rectangle": SQUARE,
    "L": ((0, 0), (4.5, 0), (4.5, 2.0), (2.4, 2.0), (2.4, 3.6), (0, 3.6)),
    "niche": ((0, 0), (4, 0), (4, 3), (2.6, 3), (2.6, 3.4), (1.4, 3.4), (1.4, 3), (0, 3)),
    "pier": ((0, 0), (4, 0), (4, 3), (2.4, 3), (2.4, 2.7), (2.0, 2.7), (2.0, 3), (0, 3)),
    "bay": ((0, 0), (4, 0), (4, 3), (3, 3), (2.5, 3.6), (1.5, 3.6), (1, 3), (0, 3)),
    "slanted": ((0, 0), (4, 0), (4, 3.7), (0, 2.8)),
    "corridor": ((0, 0), (12, 0), (12, 1.5), (0, 1.5)),
    "bathroom": ((0, 0), (2, 0), (2, 1.8), (0, 1.8)),
}
# The corner is the origin; the camera stands five metres before one wall and looks at it.
SENSOR_ORIGIN = np.array([3.0, 5.0, 1.4])


def layout(
    cloud: Cloud, options: LayoutOptions | None = None
) -> list[tuple[LayoutRoom, np.ndarray]]:
    """The rooms, each with its corners back in the scan's plan."""
    stand = level(cloud)
    rooms = find_layout(cloud.moved(stand.level_from_scan), stand, options or LayoutOptions())
    return [(room, room.found(stand).corners) for room in rooms]


def only(cloud: Cloud) -> tuple[LayoutRoom, np.ndarray]:
    rooms = layout(cloud)
    assert len(rooms) == 1
    return rooms[0]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ROOMS)
def test_corners_lie_at_the_inner_faces(name):
    truth = np.array(ROOMS[name], dtype=float)
    room, corners = only(RoomScan(ROOMS[name], noise=0.006).cloud())
    assert len(corners) == len(truth)
    assert corner_error(corners[:, :2], truth) < 0.03
    assert shapely.LinearRing(corners[:, :2]).is_ccw
    assert shapely.LinearRing(corners[:, :2]).is_simple
    assert room.guessed == ()
    assert room.ceiling == pytest.approx(2.5, abs=0.01)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("labels", ["given", "a fifth wrong", "absent"])
def test_furniture_along_walls_is_no_wall(labels):
    cloud = RoomScan(SQUARE, boxes=FURNITURE).cloud()
    rng = np.random.default_rng(0)
    label = cloud.label.copy()
    wrong = rng.random(len(label)) < (0.2 if labels == "a fifth wrong" else 0.0)
    label[wrong] = rng.choice([1, 2, 3, 5, 22], wrong.sum())
    _, corners = only(Cloud(cloud.points, label=None if labels == "absent" else label))
    assert corner_error(corners[:, :2], np.array(SQUARE)) < 0.04


def test_a_moved_scan_gives_the_moved_room():
    cloud = RoomScan(ROOMS["L"], boxes=((1.0, 0.6, 1.4, 0.8, 0.70, 0.74),)).cloud()
    matrix = motion(8.0, 27.0, (3e5, 4e6, 50.0))
    _, corners = only(cloud.moved(matrix))
    back = (corners - matrix[:3, 3]) @ matrix[:3, :3]
    assert corner_error(back[:, :2], np.array(ROOMS["L"])) < 0.03
    assert np.abs(back[:, 2]).max() < 0.01


def test_a_missing_wall_is_closed_and_said_to_be_guessed():
    room, corners = only(RoomScan(SQUARE, missing=(1,)).cloud())
    assert corner_error(corners[:, :2], np.array(SQUARE)) < 0.08
    assert len(room.guessed) == 1
    start = corners[room.guessed[0], :2]
    end = corners[(room.guessed[0] + 1) % 4, :2]
    np.testing.assert_allclose([start[0], end[0]], 4.2, atol=0.08)
    assert room.coverage < 0.85


@pytest.mark.slow
def test_a_corridor_seen_through_a_door_is_not_the_room():
    door = (1, 1.0, 1.9, 0.0, 2.05)
    cloud = RoomScan(SQUARE, holes=(door,)).cloud()
    beyond = RoomScan(((4.3, 0.4), (5.6, 0.0), (5.6, 2.9), (4.3, 2.5)), missing=(0, 2, 3)).cloud()
    both = Cloud(np.concatenate([cloud.points, beyond.points]))
    _, corners = only(both)
    assert corner_error(corners[:, :2], np.array(SQUARE)) < 0.04


@pytest.mark.slow
def test_two_rooms_are_two_polygons():
    door, other = (1, 1.0, 1.9, 0.0, 2.05), ((4.35, 0.2), (7.3, 0.2), (7.3, 3.4), (4.35, 3.4))
    first = RoomScan(SQUARE, holes=(door,)).cloud()
    second = RoomScan(other, holes=((3, 1.5, 2.4, 0.0, 2.05),)).cloud()
    found = layout(Cloud(np.concatenate([first.points, second.points])))
    assert len(found) == 2
    for truth in (np.array(SQUARE), np.array(other)):
        assert min(corner_error(corners[:, :2], truth) for _, corners in found) < 0.04


@pytest.mark.slow
def test_thirty_percent_outliers():
    cloud = RoomScan(SQUARE, boxes=FURNITURE).cloud()
    rng = np.random.default_rng(1)
    stray = rng.uniform((-1.0, -1.0, -0.5), (5.2, 4.1, 3.0), (int(0.43 * len(cloud)), 3))
    _, corners = only(Cloud(np.concatenate([cloud.points, stray])))
    assert corner_error(corners[:, :2], np.array(SQUARE)) < 0.05


@pytest.mark.slow
def test_what_a_mirror_shows_is_not_the_room():
    cloud = RoomScan(SQUARE, holes=((0, 1.0, 2.6, 0.8, 2.0),)).cloud()
    seen = cloud.points[np.abs(cloud.points[:, 0] - 1.8) < 0.4 + 0.35 * cloud.points[:, 1]]
    mirrored = seen[seen[:, 1] > 0.1] * [1.0, -1.0, 1.0]
    _, corners = only(Cloud(np.concatenate([cloud.points, mirrored])))
    assert corner_error(corners[:, :2], np.array(SQUARE)) < 0.05


@pytest.mark.slow
def test_ceilings_that_slope_or_are_missing_have_no_height():
    cloud = RoomScan(SQUARE, ceiling=False).cloud()
    assert only(cloud)[0].ceiling is None
    plan = np.random.default_rng(2).uniform((0.0, 0.0), (4.2, 3.1), (12000, 2))
    slope = np.column_stack([plan, 2.1 + 0.35 * plan[:, 1]])
    low = cloud.points[cloud.points[:, 2] < 2.1 + 0.35 * cloud.points[:, 1]]
    assert only(Cloud(np.concatenate([low, slope])))[0].ceiling is None


@pytest.mark.one_in(4)
@pytest.mark.parametrize("gable", [False, True])
def test_slopes_of_a_ceiling_are_measured(gable):
    walls = RoomScan(SQUARE, ceiling=False, height=3.4).cloud()
    plan = np.random.default_rng(3).uniform((0.0, 0.0), (4.2, 3.1), (24000, 2))

    def roof(y: np.ndarray) -> np.ndarray:
        return 3.2 - 0.6 * np.abs(y - 1.55) if gable else 2.2 + 0.35 * y

    below = walls.take(walls.points[:, 2] < roof(walls.points[:, 1]))
    points = np.concatenate([below.points, np.column_stack([plan, roof(plan[:, 1])])])
    (room, corners), *_ = layout(Cloud(points))
    assert corner_error(corners[:, :2], np.array(SQUARE)) < 0.04
    stand = level(Cloud(points))
    found = room.found(stand)
    assert found.ceiling is None
    assert len(found.as_dict()["ceiling_planes"]) == (2 if gable else 1)
    for normal, point in found.slopes:
        assert point[2] == pytest.approx(float(roof(point[1:2])[0]), abs=0.03)
        slope = (0.6 if point[1] > 1.55 else -0.6) if gable else -0.35
        true = np.array([0.0, -slope, -1.0]) / np.hypot(1.0, slope)
        assert np.rad2deg(np.arccos(min(1.0, float(normal @ true)))) < 1.0


@pytest.mark.parametrize("floor", [False, True])
def test_one_wall_is_too_little(floor):
    cloud = RoomScan(SQUARE, missing=(1, 2, 3), floor=floor, ceiling=False).cloud()
    with pytest.raises(InputError, match="too little") as caught:
        layout(cloud)
    assert "scan the floor" in str(caught.value.remedy)


def test_a_partial_view_is_closed_on_request():
    view = RoomScan(SQUARE, missing=(1, 2, 3), ceiling=False).cloud()
    room, corners = layout(view, LayoutOptions(partial=True))[0]
    assert corner_error(corners[:, :2], np.array(SQUARE)) < 0.1
    assert len(room.guessed) == 3


@pytest.mark.slow
def test_simplicity_drops_corners():
    cloud = RoomScan(ROOMS["pier"]).cloud()
    counts = [
        len(layout(cloud, LayoutOptions(simplicity=value))[0][1]) for value in (0.02, 0.1, 2.0)
    ]
    assert counts == [8, 8, 4]


def view() -> Cloud:
    """What a camera with 60 degrees sees of a floor and two walls, looking along -Y."""
    random = np.random.default_rng(3)
    a, b = random.random((2, 60_000))
    nothing = np.zeros_like(a)
    points = np.concatenate(
        [
            np.stack([6 * a, 5 * b, nothing], axis=1),
            np.stack([6 * a, nothing, 2.6 * b], axis=1),
            np.stack([nothing, 5 * a, 2.6 * b], axis=1),
        ]
    )
    right, forward, up = (
        (points - SENSOR_ORIGIN)[:, 0],
        -(points - SENSOR_ORIGIN)[:, 1],
        (points - SENSOR_ORIGIN)[:, 2],
    )
    half = np.tan(np.radians(30.0))
    seen = (np.abs(right) < half * forward) & (np.abs(up) < 0.75 * half * forward)
    return Cloud(
        points[seen] + random.normal(0, 0.004, (seen.sum(), 3)), sensor_origins=SENSOR_ORIGIN[None]
    )


@pytest.mark.slow
def test_the_room_reaches_to_the_camera() -> None:
    found = find_rooms(view(), LayoutOptions(partial=True))
    (room,) = found.rooms
    corners = room.moved(found.level.scan_from_level).corners
    plan = shapely.Polygon(corners[:, :2])
    assert plan.contains(shapely.Point(SENSOR_ORIGIN[:2]))
    # The wall that was seen is where it is, and is not guessed; those beside the camera are.
    sides = shapely.LineString([(1.0, 0.0), (5.0, 0.0)])
    assert plan.exterior.buffer(0.03).contains(sides)
    assert 0 < len(room.guessed) < len(corners)


def test_it_is_refused_where_a_whole_room_is_expected() -> None:
    with pytest.raises(InputError, match="too little"):
        find_rooms(view())


def test_what_lies_before_the_camera_is_space() -> None:
    origin = np.array([[0.0, 0.0]])
    seen = free_along_rays(np.array([[2.0, 1.0]]), origin, np.array([-0.5, -0.5]), (60, 40))
    x, y = np.meshgrid(*(0.05 * (np.arange(n) + 0.5) - 0.5 for n in seen.shape), indexing="ij")
    line = shapely.LineString([(0.0, 0.0), (2.0, 1.0)])
    away = shapely.distance(line, shapely.points(x[seen], y[seen]))
    # Pixels that the line passes, from end to end, and no others.
    assert away.max() < 0.05 * np.sqrt(0.5) + 1e-9
    assert shapely.MultiPoint(np.stack([x[seen], y[seen]], axis=1)).buffer(0.05).covers(line)
