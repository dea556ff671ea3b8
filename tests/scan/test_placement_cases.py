"""Hard cases of putting objects where they can be, and what has no place in a room."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.placement.correcting import Placement, place
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import elsewhere
from openrooms_usd.scan.registration.hints import Box, Hint
from openrooms_usd.scan.results import FoundObject
from tests.scan.placement_cases import MODELS, found, meets, outside, overlaps, points, room, shifts

TABLE = found(1, "table", (2, 1.5, 0))


def run(*items: FoundObject, home=None, unresolved="keep") -> Placement:
    return place(items, MODELS, [home or room()], unresolved=unresolved)


def sound(result: Placement, home=None) -> None:
    assert not result.unresolved
    assert not overlaps(result.objects)
    assert max(outside(item, home or room()) for item in result.objects) < 0.01


def lowest(item: FoundObject) -> float:
    return float(points(item)[:, 2].min())


@pytest.mark.parametrize("height", [0.04, -0.03, 0.09, -0.12])
def test_floating_and_sunk_furniture_comes_to_stand_on_the_floor(height: float) -> None:
    result = run(found(1, "table", (2, 1.5, height)))
    assert lowest(result.objects[0]) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(shifts(result)[1], [0, 0, -height], atol=1e-9)
    assert result.objects[0].support == "floor"


def test_a_tilted_table_is_set_upright_without_turning_or_going_away() -> None:
    result = run(found(1, "table", (2, 1.5, 0), yaw=30, tilt=4))
    placed = result.objects[0].placed
    turn = Rotation.from_quat(placed.rotation, scalar_first=True)
    # The table's own vertical, and the heading of its x axis.
    np.testing.assert_allclose(turn.apply([0, 0, 1]), [0, 0, 1], atol=1e-9)
    x = turn.apply([1, 0, 0])
    assert np.degrees(np.arctan2(x[1], x[0])) == pytest.approx(30, abs=0.1)
    assert lowest(result.objects[0]) == pytest.approx(0.0, abs=1e-9)
    # About its middle, 0.37 m high: the foot moves by 0.37 sin 4.
    assert np.linalg.norm(shifts(result)[1][:2]) == pytest.approx(
        0.37 * np.sin(np.radians(4)), abs=2e-3
    )


def test_what_leans_on_purpose_stays_leaning() -> None:
    result = run(found(1, "picture", (2, 1.5, 0.3), tilt=-25))
    turn = Rotation.from_quat(result.objects[0].placed.rotation, scalar_first=True)
    assert np.degrees(np.arccos(turn.apply([0, 0, 1])[2])) == pytest.approx(25, abs=1e-6)
    assert "leans" in result.notes[0]


def test_a_chair_pushed_under_a_table_stays() -> None:
    result = run(TABLE, found(2, "chair", (2, 1.08, 0), yaw=180))
    assert all(item.placed is item.pose for item in result.objects)
    sound(result)


def test_a_chair_whose_back_is_in_the_table_top_comes_out_by_the_least() -> None:
    # Its back ends 0.18 to 0.22 m before its middle: 2 cm into the edge of the top.
    result = run(TABLE, found(2, "chair", (2, 1.30, 0), yaw=180))
    sound(result)
    moved = shifts(result)
    assert moved[1][1] > 0 > moved[2][1]
    assert moved[1][1] - moved[2][1] == pytest.approx(0.02 + 0.0005 + 0.0, abs=0.062)


def test_two_chairs_that_overlap_share_the_way() -> None:
    result = run(found(1, "chair", (2, 1.5, 0)), found(2, "chair", (2.38, 1.5, 0)))
    sound(result)
    moved = shifts(result)
    # 6 cm, half for each: both weigh the same.
    np.testing.assert_allclose(moved[2] - moved[1], [0.06, 0, 0], atol=2e-3)
    np.testing.assert_allclose(moved[1], -moved[2], atol=1e-6)


def test_what_was_measured_well_moves_less() -> None:
    result = run(
        found(1, "chair", (2, 1.5, 0), residual=0.003, coverage=0.9),
        found(2, "chair", (2.38, 1.5, 0), residual=0.06, coverage=0.2),
    )
    moved = shifts(result)
    assert abs(moved[1][0]) < 0.2 * abs(moved[2][0])


def test_a_table_through_a_wall_comes_into_the_room() -> None:
    result = run(found(1, "table", (3.55, 1.5, 0)))
    sound(result)
    np.testing.assert_allclose(shifts(result)[1], [-0.15, 0, 0], atol=1e-3)


def test_a_wardrobe_that_reaches_into_a_wall_at_an_angle_is_turned_along_it() -> None:
    result = run(found(1, "wardrobe", (2, 2.68, 0), yaw=4))
    sound(result)
    turn = Rotation.from_quat(result.objects[0].placed.rotation, scalar_first=True)
    assert np.degrees(turn.magnitude()) == pytest.approx(0.0, abs=1e-6)
    assert np.linalg.norm(shifts(result)[1]) < 0.02


def test_a_lamp_goes_along_with_the_table_that_it_stands_on() -> None:
    result = run(found(1, "table", (3.5, 1.5, 0.02)), found(2, "table_lamp", (3.5, 1.5, 0.75)))
    sound(result)
    table, lamp = result.objects
    assert lamp.support == "1"
    np.testing.assert_allclose(shifts(result)[2][:2], shifts(result)[1][:2], atol=1e-9)
    assert lowest(lamp) == pytest.approx(0.74, abs=1e-9)
    assert meets(lamp, table, (0, 0, -0.001)) and not meets(lamp, table, (0, 0, 0.001))


def test_a_lamp_measured_beside_its_table_is_brought_onto_it() -> None:
    result = run(TABLE, found(2, "table_lamp", (2.66, 1.5, 0.75)))
    sound(result)
    assert result.objects[1].support == "1"
    assert -0.1 <= shifts(result)[2][0] < -0.04


def test_a_picture_hangs_on_its_wall() -> None:
    result = run(found(1, "picture", (2, 2.93, 1.5), yaw=3))
    item = result.objects[0]
    assert item.support == "wall"
    assert points(item)[:, 1].max() == pytest.approx(3.0, abs=1e-3)
    assert np.ptp(points(item)[:, 1]) == pytest.approx(0.024, abs=1e-6)
    assert item.placed.translation[2] == item.pose.translation[2]
    sound(result)


def test_a_pendant_lamp_hangs_from_the_ceiling_or_stays_where_none_is_known() -> None:
    lamp = found(1, "ceiling_lamp", (2, 1.5, 2.44))
    known, unknown = run(lamp), run(lamp, home=room(ceiling=None))
    assert known.objects[0].support == unknown.objects[0].support == "ceiling"
    np.testing.assert_allclose(shifts(known)[1], [0, 0, 0.06], atol=1e-9)
    assert unknown.objects[0].placed is unknown.objects[0].pose


def test_things_in_a_shelf_stand_on_its_boards() -> None:
    shelf = found(1, "bookshelf", (2, 2.85, 0.01))
    boards = (0.07, 0.47, 0.87, 1.2)
    offsets = (0.03, -0.03, 0.02, -0.03)
    things = [
        found(2 + k, "box", (1.8 + 0.1 * k, 2.86, z + dz))
        for k, (z, dz) in enumerate(zip(boards, offsets, strict=True))
    ]
    result = run(shelf, *things)
    sound(result)
    assert [lowest(item) for item in result.objects[1:]] == pytest.approx(list(boards), abs=1e-9)
    assert {item.support for item in result.objects[1:]} == {"1"}


def test_a_box_in_the_side_of_a_shelf_goes_inside() -> None:
    result = run(found(1, "bookshelf", (2, 2.85, 0)), found(2, "box", (2.38, 2.86, 0.47)))
    sound(result)
    assert shifts(result)[2][0] - shifts(result)[1][0] == pytest.approx(-0.02, abs=2e-3)


def test_a_rug_under_one_leg_lifts_the_table() -> None:
    result = run(found(1, "rug", (1.2, 1.0, 0.01)), found(2, "table", (2.2, 1.6, 0.0)))
    sound(result)
    rug, table = result.objects
    assert (rug.support, table.support) == ("floor", "1")
    assert lowest(rug) == pytest.approx(0.0, abs=1e-9)
    assert lowest(table) == pytest.approx(0.012, abs=1e-9)


def test_an_object_in_a_reflex_corner_leaves_by_the_shorter_side() -> None:
    home = room([[0, 0], [4, 0], [4, 3], [2, 3], [2, 1.5], [0, 1.5]])
    # Its corner is 6 cm beyond the one wall and 20 cm beyond the other.
    result = run(found(1, "wardrobe", (2.4, 1.26, 0)), home=home)
    sound(result, home)
    np.testing.assert_allclose(shifts(result)[1], [0, -0.06, 0], atol=1e-3)


def test_what_is_wider_than_its_niche_is_reported_and_put_in_the_middle() -> None:
    home = room([[0, 0], [4, 0], [4, 3], [2.6, 3], [2.6, 4], [1.44, 4], [1.44, 3], [0, 3]])
    result = run(found(1, "wardrobe", (2.0, 3.6, 0)), home=home)
    (left,) = result.unresolved
    assert (left.kind, left.instance, left.other) == ("in a wall", 1, None)
    assert left.depth == pytest.approx(0.02, abs=2e-3)
    assert result.objects[0].placed.translation[0] == pytest.approx(2.02, abs=2e-3)


def test_an_object_that_nothing_can_carry_is_reported() -> None:
    result = run(found(1, "box", (2, 1.5, 1.0)))
    (left,) = result.unresolved
    assert (left.kind, left.depth) == ("floats", pytest.approx(1.0))
    assert result.objects[0].support == "nothing"


def test_given_supports_are_kept() -> None:
    result = run(TABLE, found(2, "box", (2, 1.5, 1.0), support="1"))
    assert result.objects[1].support == "1"
    assert lowest(result.objects[1]) == pytest.approx(0.74, abs=1e-9)


WARDROBE = found(1, "wardrobe", (2, 1.5, 0), coverage=0.9)


def without(*items: FoundObject) -> Placement:
    return run(*items, unresolved="leave_out")


def test_what_overlaps_by_decimetres_comes_apart() -> None:
    result = without(WARDROBE, found(2, "counter", (2.65, 1.5, 0)))
    assert not result.left_out
    sound(result)


def test_of_two_in_each_other_the_worse_seen_one_is_left_out_and_the_other_does_not_move() -> None:
    result = without(WARDROBE, found(2, "wardrobe", (2, 1.5, 0), yaw=90, coverage=0.2))
    assert [(gone.instance, gone.word) for gone in result.left_out] == [(2, "wardrobe")]
    assert "inside the wardrobe (instance 1)" in result.left_out[0].reason
    assert result.objects[0].placed is result.objects[0].pose
    sound(result)


def test_one_that_overlaps_with_many_goes_alone() -> None:
    beside = [found(k, "counter", (1.0 + 0.7 * k, 2.6, 0)) for k in range(3)]
    result = without(*beside, found(9, "sofa", (1.7, 2.3, 0), coverage=0.1, residual=0.04))
    assert [gone.instance for gone in result.left_out] == [9]
    sound(result)


def test_what_lay_in_something_that_is_left_out_comes_back() -> None:
    # The sofa covers the box, and lies in both wardrobes: without it the box has its place.
    items = [
        found(1, "wardrobe", (1.2, 2.2, 0), coverage=0.9),
        found(2, "wardrobe", (2.6, 2.2, 0), coverage=0.9),
        found(3, "sofa", (1.9, 2.1, 0), coverage=0.1, residual=0.04),
        found(4, "box", (2.4, 1.4, 0), coverage=0.1, residual=0.04),
    ]
    result = without(*items)
    assert [gone.instance for gone in result.left_out] == [3]
    assert [thing.instance for thing in result.objects] == [1, 2, 4]
    sound(result)


def test_half_is_cut_off_what_would_be_left_out_and_not_off_its_neighbour() -> None:
    home = room([[0, 0], [2.38, 0], [2.38, 1.32], [0, 1.32]])
    counter, sofa = (
        found(1, "counter", (0.46, 0.76, 0)),
        found(2, "sofa", (1.05, 0.38, 0), coverage=0.9),
    )
    kept = run(counter, sofa, home=home, unresolved="leave_out").objects[0]
    assert kept.instance == 1
    assert kept.fitted is None or kept.fitted.min() >= 0.8


def test_what_floats_in_the_middle_is_left_out_and_beside_a_wall_hangs_on_it() -> None:
    result = without(found(1, "box", (2, 1.5, 1.2)), found(2, "wardrobe", (2, 2.55, 0.9)))
    assert [gone.instance for gone in result.left_out] == [1]
    assert "1.20 m above everything that can carry it" in result.left_out[0].reason
    assert [thing.support for thing in result.objects] == ["wall"]
    assert points(result.objects[0])[:, 1].max() == pytest.approx(3.0, abs=0.003)


def test_what_hangs_askew_touches_its_wall_with_a_corner() -> None:
    result = without(found(1, "box", (2, 2.75, 1.2), yaw=30))
    assert [thing.support for thing in result.objects] == ["wall"]
    assert points(result.objects[0])[:, 1].max() == pytest.approx(3.0, abs=0.003)


def test_all_stays_where_all_is_to_be_kept() -> None:
    result = place([found(1, "box", (2, 1.5, 1.2))], MODELS, [room()])
    assert len(result.objects) == len(result.unresolved) == 1
    assert not result.left_out


def blob(x: float, y: float) -> np.ndarray:
    return np.random.default_rng(3).uniform(-0.2, 0.2, (200, 3)) + np.array([x, y, 0.5])


def test_things_behind_a_wall_are_elsewhere_and_things_in_it_are_not() -> None:
    places = {1: (2.0, 1.5), 2: (4.5, 1.5), 3: (4.1, 1.5), 4: (2.0, 3.9)}
    cloud = Cloud(
        np.concatenate([blob(*place) for place in places.values()]),
        instance=np.repeat(list(places), 200).astype(np.int32),
    )
    assert elsewhere(cloud, None, [room()]) == {2, 4}
    assert elsewhere(cloud, [Hint(2), Hint(1)], [room()]) == {2}
    other = room([[4.1, 0], [8, 0], [8, 3], [4.1, 3]])
    assert elsewhere(cloud, None, [room(), other]) == {4}
    assert elsewhere(cloud, None, []) == frozenset()


def test_hints_without_points_are_elsewhere_by_their_boxes() -> None:
    cloud = Cloud(blob(2.0, 1.5))
    straight = np.array([1.0, 0.0, 0.0, 0.0])
    hints = [
        Hint(number, "chair", box=Box(np.array([x, 1.0, 0.5]), np.ones(3), straight))
        for number, x in ((1, 2.0), (2, 5.0))
    ]
    assert elsewhere(cloud, hints, [room()]) == {2}
