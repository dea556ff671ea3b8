"""What has no room is shortened by just that; what floats comes down to what is below it."""

import numpy as np
import pytest

from openrooms_usd.scan.placement.correcting import Placement, place
from openrooms_usd.scan.results import FoundObject
from tests.scan.placement_cases import MODELS, found, outside, overlaps, points, room


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


def test_what_is_more_than_a_fifth_too_long_is_left_out() -> None:
    home = room([[0, 0], [0.94, 0], [0.94, 3], [0, 3]])
    result = run(found(1, "wardrobe", (0.47, 1.5, 0)), home=home)
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
