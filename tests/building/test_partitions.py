"""Walls that stand free: closed, convex, without gaps and without reaching into anything."""

import numpy as np
import pytest
import shapely

from openrooms_usd.building.partitions import Partition, misplaced, partition_walls
from openrooms_usd.building.shell import Hole, wall_solid
from openrooms_usd.geometry.polygons import counter_clockwise

ROOM, _ = counter_clockwise([(0, 0), (6, 0), (6, 4), (0, 4)])
L_ROOM, _ = counter_clockwise([(0, 0), (6, 0), (6, 2), (3, 2), (3, 4), (0, 4)])


def partition(*ends: tuple[float, float], thickness: float = 0.1, **more: object) -> Partition:
    return Partition(f"p{ends}", np.array(ends, dtype=float), thickness, **more)


def plans(*partitions: Partition, room: np.ndarray = ROOM) -> list[shapely.Polygon]:
    return [shapely.Polygon(w.to_plan(w.outline)) for w in partition_walls(partitions, room)]


def test_one_that_ends_nowhere_is_a_rectangle_about_its_line() -> None:
    [plan] = plans(partition((2, 1), (4, 2), thickness=0.3))
    line = shapely.LineString([(2, 1), (4, 2)])
    assert (plan ^ line.buffer(0.15, cap_style="flat")).area == pytest.approx(0.0, abs=1e-9)
    [wall] = partition_walls([partition((2, 1), (4, 2), thickness=0.3)], ROOM)
    assert wall.length == pytest.approx(np.sqrt(5))
    # Seen from the side from which its line runs to the right.
    assert wall.along == pytest.approx(np.array([2, 1]) / np.sqrt(5))
    assert shapely.Point(wall.to_plan(np.array([1.0, 0.15]))).distance(line) < 1e-9


@pytest.mark.parametrize("gap", [-0.1, 0.0, 0.1])
@pytest.mark.parametrize("slant", [0.0, 0.8, -1.3])
def test_one_that_leads_to_a_wall_ends_at_its_face(gap: float, slant: float) -> None:
    [plan] = plans(partition((3, gap), (3 + slant, 2.0)))
    room = shapely.Polygon(ROOM)
    assert room.buffer(1e-9).contains(plan)
    # The whole end lies on the wall's inner face.
    touching = plan.intersection(shapely.LineString([(0, 0), (6, 0)]).buffer(1e-9))
    width = 0.1 * np.hypot(slant, 2.0 - gap) / (2.0 - gap)
    assert touching.bounds[2] - touching.bounds[0] == pytest.approx(width, abs=1e-6)


def test_into_a_corner_it_fills_the_corner() -> None:
    [plan] = plans(partition((0, 0), (2, 2)))
    assert shapely.Polygon(ROOM).buffer(1e-9).contains(plan)
    assert plan.distance(shapely.Point(0, 0)) < 1e-9


@pytest.mark.parametrize("turn", range(20, 360, 20))
def test_where_two_meet_nothing_is_open_and_nothing_is_filled_twice(turn: int) -> None:
    end = np.array([3.0, 2.0]) + 0.8 * np.array(
        [np.cos(np.radians(turn)), np.sin(np.radians(turn))]
    )
    one, two = plans(partition((4, 2), (3, 2)), partition((3, 2), tuple(end)))
    assert one.intersection(two).area < 1e-9
    joined = one.union(two.buffer(1e-9))
    assert joined.geom_type == "Polygon"
    around = shapely.Point(3, 2).buffer(0.049)
    assert around.difference(joined).area < 1e-6


def test_three_that_meet_share_the_place() -> None:
    made = plans(
        partition((3, 2), (5, 2)), partition((3.05, 2), (1, 2)), partition((3, 1.96), (3, 0.5))
    )
    assert len(made) == 3
    for i, one in enumerate(made):
        assert all(one.intersection(other).area < 1e-6 for other in made[:i])
    assert shapely.Point(3, 2).buffer(0.03).difference(shapely.union_all(made)).area < 1e-6


@pytest.mark.parametrize("tip", [2.0, 1.96, 1.9])
def test_one_that_ends_at_the_side_of_another_ends_at_its_face(tip: float) -> None:
    [other, one] = plans(partition((2, 2), (5, 2), thickness=0.2), partition((3, 0.5), (3, tip)))
    assert one.bounds[3] == pytest.approx(1.9)
    assert other.bounds[1] == pytest.approx(1.9)


def test_where_none_can_stand() -> None:
    assert misplaced(partition((3, 0), (3, 2)), ROOM) is None
    assert misplaced(partition((3, -0.1), (3, 4.1)), ROOM) is None
    for ends in ([(3, -1), (3, 2)], [(7, 0), (7, 2)], [(1, 1), (8, 1)]):
        assert misplaced(partition(*ends), ROOM) == "does not lie inside the room"
    assert misplaced(partition((3.5, 1), (2, 3.25)), L_ROOM) is None
    assert misplaced(partition((5, 1), (2, 3.5)), L_ROOM) == "does not lie inside the room"
    assert misplaced(partition((1, 0.02), (3, 0.02)), ROOM) == "lies along a wall"
    assert "0.010 m long" in str(misplaced(partition((3, 2), (3.01, 2)), ROOM))


def test_a_low_one_with_a_door_is_a_solid_of_the_right_volume() -> None:
    [wall] = partition_walls([partition((3, 0), (3, 2.5), height=2.2)], ROOM)
    assert (wall.name, wall.top(2.6), wall.top(2.0)) == (wall.partition, 2.2, 2.0)
    solid = wall_solid(wall, wall.top(2.6), [Hole(0.5, 1.4, 0.0, 2.0)])
    fans = [
        solid.points[[face[0], face[i], face[i + 1]]]
        for face in np.split(solid.indices, np.cumsum(solid.counts)[:-1])
        for i in range(1, len(face) - 1)
    ]
    volume = sum(np.linalg.det(np.array(fan)) for fan in fans) / 6.0
    assert volume == pytest.approx(0.1 * (2.5 * 2.2 - 0.9 * 2.0))
