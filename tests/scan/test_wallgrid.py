"""Walls as pictures: what stands, what lies behind, what was looked through, and its voids."""

import numpy as np
import pytest

from openrooms_usd.scan.openings.cellcounts import REACH_M, faces_of, nearest_walls
from openrooms_usd.scan.openings.rectangles import Rectangle, best_rectangle, ring
from openrooms_usd.scan.openings.wallholes import rectangles
from openrooms_usd.scan.openings.wallpicture import CELL_M, WallGrid, enclosed, wall_grids
from openrooms_usd.scan.points.sightlines import sight_of
from tests.scan.walled_rooms import CORNERS, HEIGHT, SENSOR_ORIGINS, WINDOW, Sheet, frame_of, room

ELL = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 2.0], [2.0, 4.0], [0.0, 4.0]])


def grids(*sheets: Sheet, sensor_origins: np.ndarray | None = SENSOR_ORIGINS) -> list[WallGrid]:
    cloud = room(sheets)
    sight = sight_of(cloud.points, sensor_origins)
    return list(wall_grids(cloud, CORNERS, HEIGHT, sight))


def cells(values: np.ndarray, x: tuple[float, float], z: tuple[float, float]) -> np.ndarray:
    rows, columns = ([round(v / CELL_M) for v in span] for span in (z, x))
    return values[slice(*rows), slice(*columns)]


@pytest.mark.parametrize("corners", [CORNERS, ELL])
def test_faces_are_seen_from_inside(corners: np.ndarray) -> None:
    for face in faces_of(corners):
        start, end = corners[face.number], corners[(face.number + 1) % len(corners)]
        # A little before the middle of the edge, to its left, is inside a counter-clockwise room.
        inside = (start + end) / 2 + 0.01 * np.array([-(end - start)[1], (end - start)[0]])
        x, y, z = face.from_level(np.array([[*inside, 0.7]]))[0]
        assert x == pytest.approx(face.length / 2)
        assert y == pytest.approx(-0.01 * face.length)
        assert z == 0.7
        np.testing.assert_allclose(face.left, end)


def test_frames_of_walls_go_there_and_back() -> None:
    points = np.random.default_rng(0).normal(size=(50, 3))
    for face in faces_of(ELL):
        np.testing.assert_allclose(face.to_level(face.from_level(points)), points, atol=1e-12)
        right, out = face.to_level(np.array([[1.0, 0, 0], [0, 1.0, 0]])) - [*face.left, 0]
        # Right, outwards and up are right-handed.
        np.testing.assert_allclose(np.cross(right, out), [0, 0, 1], atol=1e-12)


def test_nearest_walls_are_those_of_the_exact_distance() -> None:
    from shapely import LineString, Point

    points = np.random.default_rng(1).uniform(-0.5, 4.5, (500, 3))
    faces = faces_of(ELL)
    edges = [LineString(np.roll(ELL, -i, axis=0)[:2]) for i in range(len(ELL))]
    away = np.array([[edge.distance(Point(p[:2])) for edge in edges] for p in points])
    found = nearest_walls(points, ELL, faces)
    least = away.min(axis=1)
    assert (found[least > REACH_M + 0.02] == -1).all()
    own = least < REACH_M - 0.02
    np.testing.assert_allclose(away[own, found[own]], least[own], atol=0.03)


def test_a_recess_is_behind_and_a_hole_is_void() -> None:
    grid = grids(*frame_of(1, (0.8, 2.0), (0.9, 2.1), depth=0.08, label=WINDOW))[1]
    assert cells(grid.recess, (0.83, 1.98), (0.93, 0.95)).mean() > 0.9
    assert cells(grid.void, (0.95, 1.85), (1.05, 1.95)).min() > 0.9
    assert cells(grid.solid, (0.05, 0.75), (0.1, 2.5)).mean() > 0.99
    assert not cells(grid.solid, (0.85, 1.95), (0.95, 2.05)).any()
    assert cells(grid.labels[WINDOW], (0.8, 2.0), (0.9, 0.95)).sum() > 50


def test_nothing_is_known_behind_furniture() -> None:
    cut = Sheet(0, (1.0, 2.2), (0.0, 2.0))
    front = Sheet(0, (1.0, 2.2), (0.0, 2.0), -0.5, 3, cuts=False)
    # Wall 0 runs from right to left: the sensor stands before the sheet's middle.
    origin = np.array([[2.4, 2.5, 1.5]])
    hidden = cells(grids(cut, front, sensor_origins=origin)[0].void, (1.1, 2.1), (0.1, 1.7))
    assert (hidden == 0).all()
    assert cells(grids(cut, sensor_origins=origin)[0].void, (1.1, 2.1), (0.1, 1.7)).min() > 0.3


def test_relief_is_how_far_the_face_stands_out() -> None:
    board = Sheet(2, (1.0, 1.5), (0.5, 1.5), -0.02)
    relief = grids(board)[2].relief
    wall = np.nanmedian(cells(relief, (2.0, 3.5), (0.5, 1.5)))
    assert np.nanmedian(cells(relief, (1.05, 1.45), (0.55, 1.45))) - wall == pytest.approx(
        0.02, abs=0.002
    )


def test_a_wall_that_stands_askew_is_taken_as_it_stands() -> None:
    cloud = room(noise=0.0)
    corners = CORNERS + np.array([[0.0, 0.04], [0.0, -0.03], [0.0, 0.0], [0.0, 0.0]])
    grid = next(wall_grids(cloud, corners, HEIGHT, sight_of(cloud.points, SENSOR_ORIGINS)))
    assert np.abs(np.nanmedian(grid.relief[10:-10, 10:-10], axis=0)).max() < 0.004
    assert grid.solid.mean() > 0.97


def test_the_other_side_of_a_wall_is_not_its_recess() -> None:
    cloud = room([Sheet(0, (0.0, 4.0), (0.0, HEIGHT), 0.1, cuts=False)])
    assert cloud.normals is not None
    back = cloud.points[:, 1] < -0.05
    cloud.normals[back] *= -1
    grid = next(wall_grids(cloud, CORNERS, HEIGHT, sight_of(cloud.points, SENSOR_ORIGINS)))
    assert not grid.recess.any()


def test_eyes_see_what_nothing_hides() -> None:
    z, y = (axis.ravel() for axis in np.meshgrid(np.arange(0, 2, 0.02), np.arange(-1, 1, 0.02)))
    screen = np.column_stack([np.full(len(z), 1.0), y, z])
    far = np.column_stack([np.full(len(z), 3.0), y, z])
    sight = sight_of(np.concatenate([screen, far]), np.array([[0.0, 0.0, 1.0]]))
    outward = np.array([1.0, 0.0, 0.0])
    before, behind = np.array([[0.8, 0.0, 1.0]]), np.array([[2.0, 0.0, 1.0]])
    assert sight.sensors_looking_at(before, outward) == [1]
    assert sight.sensors_looking_at(behind, outward) == [0]
    # From its back nobody looks at a surface.
    assert sight.sensors_looking_at(before, -outward) == [0]


def exhaustive(weights: np.ndarray) -> float:
    total = np.pad(weights.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    rows, columns = total.shape
    return max(
        total[t, r] - total[b, r] - total[t, left] + total[b, left]
        for b in range(rows)
        for t in range(b + 1, rows)
        for left in range(columns)
        for r in range(left + 1, columns)
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_block_among_noise_is_found_to_the_cell(seed: int) -> None:
    random = np.random.default_rng(seed)
    weights = random.normal(-1.0, 0.3, (17, 23))
    bottom, left = random.integers(1, 6, size=2)
    weights[bottom : bottom + 9, left : left + 11] += 2.0
    found, value = best_rectangle(weights)
    assert found == Rectangle(bottom, bottom + 9, left, left + 11)
    assert value == pytest.approx(exhaustive(weights))
    assert value == pytest.approx(weights[found.rows, found.columns].sum())


@pytest.mark.parametrize("shape", [(1, 1), (2, 40), (7, 3), (31, 8)])
def test_everything_is_best_where_everything_is_positive(shape: tuple[int, int]) -> None:
    found, value = best_rectangle(np.ones(shape))
    assert (found.bottom, found.top, found.left, found.right) == (0, shape[0], 0, shape[1])
    assert value == shape[0] * shape[1]


def test_nothing_positive_gives_nothing_positive() -> None:
    assert best_rectangle(-np.ones((12, 12)))[1] < 0


def test_strips_around_a_rectangle_stay_inside() -> None:
    strips = ring((20, 30), Rectangle(0, 10, 5, 29), 3)
    assert strips == {
        "left": Rectangle(0, 10, 2, 5),
        "right": Rectangle(0, 10, 29, 30),
        "top": Rectangle(10, 13, 5, 29),
    }


ROWS, COLUMNS = 100, 160


def test_a_void_goes_no_farther_up_than_the_wall_beside_it() -> None:
    standing = np.zeros((ROWS, COLUMNS), dtype=bool)
    standing[:84] = True
    door = np.s_[:82, 60:95]
    standing[door] = False
    # Above 2.1 m nobody looked, and beside the door's upper part something hides the wall.
    void = np.zeros_like(standing)
    void[:, 60:95] = True
    kept = enclosed(void, standing)
    assert kept[:84, 60:95].all()
    assert not kept[84:].any()
    # Where one side was never seen that high, neither is known the other side's height.
    standing[70:, :95] = False
    assert not enclosed(void, standing)[70:].any()


def test_what_is_wider_than_doors_up_to_the_top_was_not_looked_at() -> None:
    standing = np.ones((ROWS, COLUMNS), dtype=bool)
    void = np.zeros_like(standing)
    void[60:, 20:130] = True
    void[:60, 60:95] = True
    kept = enclosed(void, standing & ~void)
    assert kept[:60, 60:95].all()
    assert not kept[60:].any()


def test_slits_are_no_holes_and_windows_stay_whole() -> None:
    void = np.zeros((ROWS, COLUMNS), dtype=bool)
    void[30:80, 10:13] = True
    void[40:80, 40:150] = True
    kept = enclosed(void, ~void)
    assert not kept[:, :20].any()
    assert kept[40:80, 40:150].all()


@pytest.mark.parametrize(("apart", "count"), [(4, 1), (6, 2)])
def test_holes_that_a_mullion_parts_are_one(apart: int, count: int) -> None:
    weights = np.full((ROWS, COLUMNS), -1.0)
    weights[40:88, 20:50] = weights[40:88, 50 + apart : 90] = 1.0
    found = list(rectangles(weights))
    assert len(found) == count
    assert found[0].top - found[0].bottom == pytest.approx(1.2 / CELL_M)


def test_holes_at_different_heights_are_two() -> None:
    weights = np.full((ROWS, COLUMNS), -1.0)
    # What a curtain between them hides says nothing.
    weights[30:90, 50:53] = -0.03
    weights[20:70, 20:50] = weights[40:90, 53:83] = 1.0
    assert list(rectangles(weights)) == [Rectangle(20, 70, 20, 50), Rectangle(40, 90, 53, 83)]
