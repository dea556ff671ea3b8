"""What has no place is left out and told; what stands in another room is no part of this one."""

import numpy as np
import pytest

from openrooms_usd.scan.placement.correcting import Placement, place
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import elsewhere
from openrooms_usd.scan.registration.hints import Box, Hint
from openrooms_usd.scan.results import FoundObject
from tests.scan.placement_cases import MODELS, found, outside, overlaps, points, room

WARDROBE = found(1, "wardrobe", (2, 1.5, 0), coverage=0.9)


def run(*items: FoundObject) -> Placement:
    return place(items, MODELS, [room()], unresolved="leave_out")


def sound(result: Placement) -> None:
    assert not result.unresolved
    assert not overlaps(result.objects)
    assert max(outside(item, room()) for item in result.objects) < 0.01


def test_what_overlaps_by_decimetres_comes_apart() -> None:
    result = run(WARDROBE, found(2, "counter", (2.65, 1.5, 0)))
    assert not result.left_out
    sound(result)


def test_of_two_in_each_other_the_worse_seen_one_is_left_out_and_the_other_does_not_move() -> None:
    result = run(WARDROBE, found(2, "wardrobe", (2, 1.5, 0), yaw=90, coverage=0.2))
    assert [(gone.instance, gone.word) for gone in result.left_out] == [(2, "wardrobe")]
    assert "inside the wardrobe (instance 1)" in result.left_out[0].reason
    assert result.objects[0].placed is result.objects[0].pose
    sound(result)


def test_one_that_overlaps_with_many_goes_alone() -> None:
    beside = [found(k, "counter", (1.0 + 0.7 * k, 2.6, 0)) for k in range(3)]
    result = run(*beside, found(9, "sofa", (1.7, 2.3, 0), coverage=0.1, residual=0.04))
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
    result = run(*items)
    assert [gone.instance for gone in result.left_out] == [3]
    assert [thing.instance for thing in result.objects] == [1, 2, 4]
    sound(result)


def test_what_floats_in_the_middle_is_left_out_and_beside_a_wall_hangs_on_it() -> None:
    result = run(found(1, "box", (2, 1.5, 1.2)), found(2, "wardrobe", (2, 2.55, 0.9)))
    assert [gone.instance for gone in result.left_out] == [1]
    assert "1.20 m above all that may carry it" in result.left_out[0].reason
    assert [thing.support for thing in result.objects] == ["wall"]
    assert points(result.objects[0])[:, 1].max() == pytest.approx(3.0, abs=0.003)


def test_what_hangs_askew_touches_its_wall_with_a_corner() -> None:
    result = run(found(1, "box", (2, 2.75, 1.2), yaw=30))
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
