"""What carries what, and how far it is from it; and the least motion by itself."""

import numpy as np
import pytest

from openrooms_usd.scan.placement.arrangement import arranged
from openrooms_usd.scan.placement.bodies import Body, solid
from openrooms_usd.scan.placement.enclosure import Enclosure
from openrooms_usd.scan.placement.spreading import Condition, least_motion
from openrooms_usd.scan.placement.support import rest
from tests.scan.placement_cases import MODELS, found

X, Y = np.array([1.0, 0.0]), np.array([0.0, 1.0])
ELL = Enclosure(np.array([[0, 0], [4, 0], [4, 3], [2, 3], [2, 1.5], [0, 1.5]], dtype=float), 0, 2.5)


def bodies(*items) -> list[Body]:
    return arranged(items, MODELS, []).bodies


@pytest.mark.parametrize("height", [0.74, 0.78, 0.70])
def test_the_gap_to_a_table_top(height: float) -> None:
    table, box = bodies(found(1, "table", (0, 0, 0)), found(2, "box", (0.2, 0.1, height)))
    there = rest(box, table)
    assert there is not None and there.gap == pytest.approx(height - 0.74, abs=1e-9)
    assert there.share == 1.0


def test_half_of_a_box_over_an_edge() -> None:
    table, box = bodies(found(1, "table", (0, 0, 0)), found(2, "box", (0.6, 0, 0.75)))
    there = rest(box, table)
    assert there is not None and there.share == pytest.approx(0.5, abs=0.05)


def test_nothing_below() -> None:
    table, box = bodies(found(1, "table", (0, 0, 0)), found(2, "box", (0.9, 0, 0.75)))
    assert rest(box, table) is None


def test_a_pointed_foot_is_not_missed_between_lines() -> None:
    tip = np.array([[0, 0, 0], [0.3, 0.3, 0.4], [-0.3, 0.3, 0.4], [0, -0.4, 0.4]], dtype=float)
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    (table,) = bodies(found(1, "table", (0.01, 0.02, 0)))
    there = rest(Body(solid(tip + np.array([0, 0, 0.75]), faces), np.eye(2)), table)
    assert there is not None and there.gap == pytest.approx(0.01, abs=1e-6)


def test_an_l_shaped_room() -> None:
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    assert ELL.leave(square + np.array([1.0, 0.8])) == {}
    # In the outer corner both walls, at the inner corner the nearer one.
    assert ELL.leave(square + np.array([0.4, 0.3])) == pytest.approx({0: 0.2, 5: 0.1})
    around = np.concatenate([square, [[-0.5, 0.45], [-0.45, 0.5]]]) + np.array([2.42, 1.1])
    assert ELL.leave(around) == pytest.approx({3: 0.08})
    gaps = ELL.gaps(square + np.array([3.4, 0.6]))
    assert gaps == pytest.approx({0: 0.1, 1: 0.1})


def test_the_nearest_wall_and_the_turn_along_it() -> None:
    (wardrobe,) = bodies(found(1, "wardrobe", (1.0, 1.15, 0), yaw=5))
    facing = ELL.facing(wardrobe)
    assert facing is not None and facing.wall == 4
    assert np.degrees(facing.angle) == pytest.approx(-5)
    assert facing.gap == pytest.approx(0.05, abs=1e-6)


def test_the_least_motion_against_a_closed_form() -> None:
    """Two objects apart by d share it in inverse proportion to their weights."""
    apart = Condition({1: X, 0: -X}, 0.3, 1e-9)
    motion = least_motion(np.array([1.0, 2.0]), np.eye(2), [apart])
    np.testing.assert_allclose(motion, [[-0.2, 0], [0.1, 0]], atol=1e-6)


def test_a_wall_behind_one_leaves_the_way_to_the_other() -> None:
    rows = [Condition({1: X, 0: -X}, 0.3, 1e-9), Condition({0: X}, -0.05, 1e-9)]
    motion = least_motion(np.ones(2), np.eye(2), rows)
    np.testing.assert_allclose(motion, [[-0.05, 0], [0.25, 0]], atol=1e-6)


def test_what_is_carried_moves_along_for_nothing() -> None:
    carried = np.array([[1.0, 0.0], [1.0, 1.0]])
    motion = least_motion(np.ones(2), carried, [Condition({0: Y}, 0.1, 1e-9)])
    np.testing.assert_allclose(carried @ motion, [[0, 0.1], [0, 0.1]], atol=1e-6)


def test_contradictions_end_in_the_middle_and_the_harder_condition_wins() -> None:
    both = [Condition({0: X}, 0.1, 1e-6), Condition({0: -X}, 0.1, 1e-6)]
    np.testing.assert_allclose(least_motion(np.ones(1), np.eye(1), both), 0.0, atol=1e-6)
    uneven = [both[0], Condition({0: -X}, 0.1, 1e-9)]
    np.testing.assert_allclose(least_motion(np.ones(1), np.eye(1), uneven)[0, 0], -0.1, atol=1e-3)


def test_a_corner_of_the_room_that_sticks_into_the_side_of_something_is_seen() -> None:
    """The side of a wardrobe, 4 cm beyond the inner corner, none of its own corners outside."""
    middle = np.array([2.0, 1.5]) + (0.3 - 0.04) * np.array([1.0, -1.0]) / np.sqrt(2.0)
    (wardrobe,) = bodies(found(1, "wardrobe", (*middle, 0), yaw=45))
    assert ELL.beyond(wardrobe.outline).max() == 0.0
    footprint = ELL.footprint(wardrobe)
    way = ELL.leave(footprint)
    # Along one of the walls' normals: the depth across the side times the root of two.
    assert list(way.values()) == pytest.approx([0.04 * np.sqrt(2.0)], abs=4e-3)
