"""Outlines as lines: their corners, the moves that make them plainer, and fits to points."""

import numpy as np
import pytest

from openrooms_usd.scan.points.surfels import surfels
from openrooms_usd.scan.rooms.outline import Outline, outline_of, simplified
from openrooms_usd.scan.rooms.roomoutline import Cost, refitted, with_piers
from openrooms_usd.scan.rooms.spaces import find_spaces
from openrooms_usd.scan.rooms.walls import upright
from tests.scan.scanned_rooms import RoomScan, corner_error

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
NOTCHED = np.array(
    [[0, 0], [4, 0], [4, 3], [2.5, 3], [2.5, 3.3], [2.0, 3.3], [2.0, 3], [0, 3.0]], dtype=float
)
PIER = ((0, 0), (4, 0), (4, 3), (2.5, 3), (2.5, 2.7), (2.0, 2.7), (2.0, 3), (0, 3))


def count_and_area(outline: Outline) -> float:
    corners = outline.corners()
    x, y = corners.T
    area = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    return 0.1 * len(outline) + abs(area - 12.0)


@pytest.mark.parametrize("corners", [SQUARE, NOTCHED, SQUARE[[0, 1, 2]]])
def test_corners_go_to_lines_and_back(corners):
    outline = outline_of(corners)
    np.testing.assert_allclose(outline.corners(), corners, atol=1e-12)
    assert outline.valid()


def test_collinear_and_repeated_corners_vanish():
    more = np.insert(SQUARE, 1, [[1.0, 0.0], [1.0, 0.0], [2.0, 0.0]], axis=0)
    assert len(outline_of(more)) == 4


def test_clockwise_and_crossing_outlines_are_not_valid():
    assert not outline_of(SQUARE[::-1]).without([0, 1]).valid()
    crossed = Outline(outline_of(SQUARE).normals, np.array([0.0, -1.0, 3.0, 0.0]))
    assert not crossed.valid()


def test_a_niche_goes_when_corners_cost_more():
    plain = simplified(outline_of(NOTCHED), count_and_area)
    assert len(plain) == 4
    assert corner_error(plain.corners(), SQUARE) < 1e-9
    kept = simplified(outline_of(NOTCHED), lambda o: count_and_area(o) * (len(o) > 7) or 9.0)
    assert len(kept) == 8


def test_two_halves_of_a_bent_wall_become_one():
    bent = np.insert(SQUARE, 1, [[2.0, -0.05]], axis=0)
    assert len(simplified(outline_of(bent), count_and_area)) == 4


def test_walls_move_to_their_points():
    walls = upright(surfels(RoomScan(SQUARE, noise=0.01).cloud()))
    rough = SQUARE + np.array([[0.04, -0.03], [-0.05, 0.02], [0.03, 0.05], [-0.04, -0.04]])
    found = refitted(outline_of(rough), walls, (0.0,))
    assert corner_error(found.corners(), SQUARE) < 0.006
    turns = np.abs(found.normals @ np.roll(found.normals, 1, axis=0).T).diagonal()
    np.testing.assert_allclose(turns, 0.0, atol=1e-9)


def test_a_wall_off_the_directions_keeps_its_own():
    slanted = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.2], [0.0, 2.9]])
    walls = upright(surfels(RoomScan(slanted).cloud()))
    found = refitted(outline_of(slanted + 0.02), walls, (0.0,))
    assert corner_error(found.corners(), slanted) < 0.01


def test_a_pier_is_added_around_wall_that_stands_inside():
    pieces = surfels(RoomScan(PIER).cloud())
    walls = upright(pieces)
    spaces = find_spaces(pieces, walls)
    gain = np.zeros(spaces.seen.size)
    cost = Cost(walls, spaces.centres(), gain, spaces.standing.ravel(), 0.1)
    found = with_piers(outline_of(SQUARE), spaces, walls.thickness, cost)
    assert corner_error(found.corners(), np.array(PIER, dtype=float)) < 0.06
    dear = Cost(walls, spaces.centres(), gain, spaces.standing.ravel(), 5.0)
    assert len(with_piers(outline_of(SQUARE), spaces, walls.thickness, dear)) == 4


def test_an_outline_without_the_places_where_people_stood_is_dear():
    scan = RoomScan(SQUARE)
    walls = upright(surfels(scan.cloud()))
    sensors = np.array([[1.0, 1.0], [3.5, 1.0], [3.6, 2.0], [3.7, 1.5]])
    nothing = np.zeros(0)
    costs = [Cost(walls, np.zeros((0, 2)), nothing, nothing, 0.1, (), s) for s in (None, sensors)]
    half = outline_of(SQUARE * [0.5, 1.0])
    whole = outline_of(SQUARE)
    free, dear = ([cost(outline) for cost in costs] for outline in (whole, half))
    assert free[0] == free[1]
    # Three of four places lie outside the half.
    assert dear[1] - dear[0] == pytest.approx(0.75 * 30.0)
