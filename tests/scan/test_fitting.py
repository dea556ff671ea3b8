"""Outlines as lines, their fits, and solids that are shortened or put down where they float."""

import numpy as np
import pytest

from openrooms_usd.scan.placement.correcting import Placement, place
from openrooms_usd.scan.points.surfels import surfels
from openrooms_usd.scan.results import FoundObject
from openrooms_usd.scan.rooms.outline import Outline, outline_of, simplified
from openrooms_usd.scan.rooms.roomoutline import Cost, refitted, with_piers
from openrooms_usd.scan.rooms.spaces import find_spaces
from openrooms_usd.scan.rooms.walls import upright
from tests.scan.placement_cases import MODELS, found, outside, overlaps, points, room
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


def run(*items: FoundObject, home=None) -> Placement:
    return place(items, MODELS, [home or room()], unresolved="leave_out")


@pytest.mark.parametrize("yaw", [0.0, 90.0])
def test_a_box_too_long_between_two_walls_is_shortened_by_just_that(yaw: float) -> None:
    # 1.20 m long, in a room of 1.10 m.
    corners = (
        [[0, 0], [1.1, 0], [1.1, 3], [0, 3]] if not yaw else [[0, 0], [4, 0], [4, 1.1], [0, 1.1]]
    )
    home = room(corners)
    middle = (0.55, 1.5, 0) if not yaw else (2.0, 0.55, 0)
    result = run(found(1, "wardrobe", middle, yaw=yaw), home=home)
    assert not result.left_out and not result.unresolved
    (thing,) = result.objects
    # Two clearances of half a millimetre.
    np.testing.assert_allclose(thing.fitted, [1.099 / 1.2, 1.0, 1.0], atol=2e-4)
    np.testing.assert_allclose(thing.pose.scale, thing.fitted)
    assert np.ptp(points(thing), axis=0)[int(yaw > 0)] == pytest.approx(1.099, abs=3e-4)
    assert outside(thing, home) < 1e-3
    assert thing.as_dict()["fitted"] == thing.fitted.tolist()


@pytest.mark.parametrize(("width", "place"), [(0.94, 0.47), (1.6, 1.6)])
def test_a_thing_of_this_room_is_cut_by_half_or_moved_before_it_is_left_out(
    width: float, place: float
) -> None:
    # 1.20 m long: with a wall on either side, or half behind one.
    home = room([[0, 0], [width, 0], [width, 3], [0, 3]])
    result = run(found(1, "wardrobe", (place, 1.5, 0)), home=home)
    assert not result.left_out and not result.unresolved
    assert outside(result.objects[0], home) < 1e-3


def test_what_is_more_than_half_too_long_is_left_out() -> None:
    home = room([[0, 0], [0.5, 0], [0.5, 3], [0, 3]])
    result = run(found(1, "wardrobe", (0.25, 1.5, 0)), home=home)
    assert [gone.instance for gone in result.left_out] == [1]


def test_of_two_between_walls_the_worse_measured_one_gives_way() -> None:
    # Two of 1.20 m side by side in 2.30 m.
    home = room([[0, 0], [2.3, 0], [2.3, 0.7], [0, 0.7]])
    pair = [
        found(1, "wardrobe", (0.6, 0.35, 0), coverage=0.9),
        found(2, "wardrobe", (1.7, 0.35, 0), coverage=0.2, residual=0.03),
    ]
    for items in (pair, pair[::-1]):
        result = run(*items, home=home)
        assert not result.left_out and not result.unresolved
        assert not overlaps(result.objects, 0.002)
        by_number = {thing.instance: thing for thing in result.objects}
        assert by_number[1].fitted is None
        # Overlaps up to 4 mm are none.
        assert by_number[2].fitted[0] == pytest.approx(1.1 / 1.2, abs=4.5e-3)


def test_nothing_is_shortened_that_has_room_or_is_to_be_kept() -> None:
    beside = found(1, "wardrobe", (0.57, 1.5, 0))
    assert run(beside).objects[0].fitted is None
    narrow = room([[0, 0], [1.1, 0], [1.1, 3], [0, 3]])
    kept = place([beside], MODELS, [narrow], unresolved="keep")
    assert kept.objects[0].fitted is None
    assert kept.unresolved


def test_what_floats_half_a_metre_at_most_comes_down_to_the_nearest_top() -> None:
    table = found(1, "table", (2, 1.5, 0))
    result = run(table, found(2, "box", (2, 1.5, 0.74 + 0.45)), found(3, "box", (1, 0.9, 0.45)))
    assert not result.left_out and not result.unresolved
    supports = {thing.instance: thing.support for thing in result.objects}
    assert supports == {1: "floor", 2: "1", 3: "floor"}
    assert points(result.objects[1])[:, 2].min() == pytest.approx(0.74, abs=1e-6)


def test_a_lamp_far_above_all_hangs() -> None:
    lamp = found(1, "table_lamp", (2, 1.5, 1.9), word="lamp")
    result = run(lamp, home=room(ceiling=None))
    assert [thing.support for thing in result.objects] == ["ceiling"]
