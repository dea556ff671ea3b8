"""Doors: open leaves, what is seen through them, and closed ones by their frames' relief."""

from dataclasses import replace

import numpy as np
import pytest

from openrooms_usd.scan.openings.detection import find_openings
from openrooms_usd.scan.openings.judgement import frames
from openrooms_usd.scan.openings.wallpicture import CELL_M, WallGrid, wall_grids
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.sightlines import sight_of
from openrooms_usd.scan.points.surfels import surfels
from openrooms_usd.scan.rooms.layout import find_layout, open_leaves
from openrooms_usd.scan.rooms.levelling import level
from openrooms_usd.scan.rooms.spaces import PIXEL_M, _markers, _rooms, at_sensor_height, free_space
from tests.scan.scanned_rooms import DOOR, SQUARE, RoomScan, corner_error
from tests.scan.walled_rooms import CORNERS, HEIGHT, SENSOR_ORIGINS, Sheet, casing_of, room

LONG = ((0.0, 0.0), (4.2, 0.0), (4.2, 4.5), (0.0, 4.5))
# The wall at x = 4.2 has a door from 1 to 1.9 m; nothing higher than 2 m was scanned.
DOORWAY = (1, 1.0, 1.9, 0.0, 2.5)


def leaf(degrees: float, hinge: tuple[float, float] = (4.2, 1.9), label: int = DOOR) -> Cloud:
    """A door's leaf of 0.9 x 2 m that was opened into the room."""
    turn = np.deg2rad(degrees)
    s, z = (axis.ravel() for axis in np.meshgrid(np.arange(0, 0.9, 0.02), np.arange(0, 2, 0.02)))
    run = np.array([-np.sin(turn), -np.cos(turn)])
    noise = np.random.default_rng(3).normal(0.0, 0.004, (len(s), 3))
    points = np.column_stack([np.array(hinge) + s[:, None] * run, z]) + noise
    return Cloud(points, label=np.full(len(s), label, np.int32))


def both(a: Cloud, b: Cloud) -> Cloud:
    assert a.label is not None and b.label is not None
    points, label = np.concatenate([a.points, b.points]), np.concatenate([a.label, b.label])
    return Cloud(points, label=label)


def scanned(degrees: float) -> Cloud:
    """A room up to 2 m with its open leaf; nobody looked into the corner behind that."""
    room = RoomScan(LONG, height=2.0, ceiling=False, holes=(DOORWAY,)).cloud()
    x, y = room.points[:, :2].T
    return both(room.take(~((x > 3.65) & (y > 1.2))), leaf(degrees))


def test_a_leaf_that_stands_off_the_walls_is_none_of_them():
    pieces = surfels(scanned(38.0))
    found = open_leaves(pieces, (0.0,))
    assert pieces.label is not None
    away = np.abs(4.2 - pieces.points[:, 0]) > 0.2
    upper = (pieces.label == DOOR) & away & (pieces.points[:, 2] > 0.15)
    assert found[upper].mean() > 0.9
    assert not found[pieces.label != DOOR].any()


def test_a_closed_leaf_is_wall_in_oblique_walls_as_well():
    closed = both(RoomScan(SQUARE, holes=(DOORWAY,)).cloud(), leaf(0.0))
    turn = np.deg2rad(27.0)
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    pieces = surfels(closed.moved(matrix))
    assert not open_leaves(pieces, (27.0,)).any()
    assert open_leaves(pieces, (0.0,)).mean() < 0.002
    assert not open_leaves(replace(pieces, label=None), (0.0,)).any()


def test_a_room_is_whole_behind_an_open_leaf():
    cloud = scanned(38.0)
    stand = level(cloud)
    (room,) = find_layout(cloud.moved(stand.level_from_scan), stand)
    assert corner_error(room.found(stand).corners[:, :2], np.array(LONG)) < 0.06


def test_what_lies_behind_a_slit_in_a_wall_is_no_part_of_the_room():
    # 3 m x 3 m, and a corridor of 65 cm behind a wall.
    barrier = np.zeros((60, 75), bool)
    barrier[[0, -1]] = barrier[:, [0, 60, -1]] = True
    barrier[30:34, 60] = False
    rooms, count = _rooms(~barrier, barrier)
    assert count == 1
    assert (rooms[2:58, 2:58] == 1).all()
    assert (rooms[2:58, 63:73] == 0).all()
    barrier[20:45, 60] = False
    rooms, count = _rooms(~barrier, barrier)
    assert count == 1
    assert (rooms[22:42, 63:73] == 1).all()


def test_narrow_ends_of_a_wide_space_have_no_marker_of_their_own():
    width = np.concatenate([np.full(20, 0.8), np.full(20, 0.3), np.full(4, 0.1), np.full(9, 0.4)])
    markers, count = _markers(width[:, None] * np.ones(3))
    assert count == 2
    assert (markers[:20] == 1).all() and (markers[20:44] == 0).all() and (markers[44:] == 2).all()


def test_nobody_looks_through_what_stands_at_the_height_of_the_eyes():
    shelf = ((2.02, 0.3, 0.3, 2.4, 0.0, 1.9),)
    low, shape = np.array([-0.5, -0.5]), (110, 84)
    pieces = surfels(RoomScan(SQUARE, boxes=shelf, missing=(3,)).cloud())
    for origin, blocked in ((1.5, True), (2.3, False)):
        solid = at_sensor_height(pieces, origin, low, shape)
        assert solid[int(2.52 / PIXEL_M), int(2.0 / PIXEL_M)] == blocked
    barrier = np.zeros(shape, bool)
    barrier[round(4.7 / PIXEL_M), 10:72] = True
    sensor_origins = (np.array([[0.6, 1.5]]) - low) / PIXEL_M
    behind = round(3.5 / PIXEL_M), round(2.0 / PIXEL_M)
    assert free_space(barrier, sensor_origins)[behind]
    assert not free_space(barrier | at_sensor_height(pieces, 1.5, low, shape), sensor_origins)[
        behind
    ]


GAP = Sheet(0, (2.5, 3.4), (0.0, 2.1))


def beside(before: float) -> list[Sheet]:
    """A leaf beside the doorway, so far before the pier."""
    return [Sheet(0, (1.5, 2.4), (0.0, 2.1), -before, DOOR)]


def test_a_leaf_opened_against_the_pier_is_no_door_there() -> None:
    found = find_openings(room([GAP, *beside(0.16)]), CORNERS, HEIGHT)
    assert len(found) == 1
    (door,) = found
    along = abs(door.corners[1, 0] - door.corners[0, 0])
    assert door.type == "door" and abs(along - 0.9) < 0.15


def test_a_closed_leaf_in_its_wall_is_a_door() -> None:
    found = find_openings(room([GAP, *beside(0.02)]), CORNERS, HEIGHT)
    assert [door.type for door in found] == ["door", "door"]


def wall(sheets: list[Sheet], noise: float = 0.003) -> WallGrid:
    """The picture of the first wall."""
    cloud = room(sheets, labels=False, noise=noise)
    return next(wall_grids(cloud, CORNERS, HEIGHT, sight_of(cloud.points, SENSOR_ORIGINS)))


@pytest.mark.parametrize(("proud", "noise"), [(0.01, 0.003), (0.015, 0.01), (0.03, 0.005)])
def test_boards_around_a_leaf(proud: float, noise: float) -> None:
    grid = wall(casing_of(0, (1.5, 2.4), 2.05, proud), noise)
    ((where, clear),) = frames(grid)
    edges = CELL_M * np.array([where.left, where.right, where.top])
    np.testing.assert_allclose(edges, [1.5, 2.4, 2.05], atol=CELL_M)
    assert where.bottom == 0
    assert 0 < clear <= 1


def test_a_leaf_that_lies_deeper_than_the_wall() -> None:
    grid = wall([Sheet(0, (1.5, 2.4), (0.0, 2.05), 0.02, DOOR)])
    ((where, _),) = frames(grid)
    edges = CELL_M * np.array([where.left, where.right, where.top])
    np.testing.assert_allclose(edges, [1.5, 2.4, 2.05], atol=2 * CELL_M)


@pytest.mark.parametrize(
    "sheets",
    [
        [],
        # A picture, a board that ends above the floor, a shelf as high as a hip, and a step.
        [Sheet(0, (1.5, 2.4), (1.0, 2.0), -0.02)],
        [s for s in casing_of(0, (1.5, 2.4), 2.05, 0.015) if s.z[0] > 0],
        casing_of(0, (1.5, 2.4), 1.0, 0.015),
        [Sheet(0, (2.0, 4.0), (0.0, HEIGHT), -0.02)],
    ],
)
def test_what_is_no_door(sheets: list[Sheet]) -> None:
    assert list(frames(wall(sheets))) == []


def test_a_low_wall_has_no_door() -> None:
    cloud = room([])
    grid = next(wall_grids(cloud, CORNERS, 1.5, sight_of(cloud.points, SENSOR_ORIGINS)))
    assert list(frames(grid)) == []
