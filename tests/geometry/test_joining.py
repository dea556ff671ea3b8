"""Floors that stand wall to wall become one outline, with the walls between them."""

import numpy as np
import pytest
import shapely

from openrooms_usd.building.partitions import Partition, misplaced, partition_walls
from openrooms_usd.geometry.joining import joined_floors, walls_between


def box(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)


LEFT, RIGHT = box(0, 0, 3, 4), box(3.2, 1, 6, 4)
# Four rooms with walls of 0.2 m, of which no two crossing ones are in line by chance.
FOUR = (box(0, 0, 3, 2), box(3.2, 0, 6, 2), box(0, 2.2, 3, 5), box(3.2, 2.2, 6, 5))


@pytest.mark.parametrize("turn", [0.0, 30.0, 145.0])
def test_two_floors_have_the_wall_that_both_look_at(turn: float) -> None:
    c, s = np.cos(np.deg2rad(turn)), np.sin(np.deg2rad(turn))
    about = np.array([[c, s], [-s, c]])
    floors = [LEFT @ about, RIGHT @ about]
    outline, members = joined_floors(floors, 0) or pytest.fail("not joined")
    assert members == [0, 1]
    assert shapely.Polygon(outline).area == pytest.approx(12.0 + 8.4 + 0.2 * 3)
    (wall,) = walls_between(floors)
    assert wall.thickness == pytest.approx(0.2)
    assert wall.sides == ((0, 1), (1, 3))
    ends = np.sort(wall.ends @ about.T, axis=0)
    assert ends == pytest.approx(np.array([[3.1, 1.0], [3.1, 4.0]]))


@pytest.mark.parametrize(("gap", "count"), [(0.0, 2), (0.5, 2), (0.52, 1)])
def test_floors_farther_apart_than_a_wall_stay_alone(gap: float, count: int) -> None:
    floors = [box(0, 0, 3, 3), box(3 + gap, 0, 6, 3), box(20, 0, 23, 3)]
    found = joined_floors(floors, 0)
    assert (1 if found is None else len(found[1])) == count
    assert len(walls_between(floors)) == count - 1


def test_what_nobody_saw_from_either_side_is_open() -> None:
    assert not walls_between([LEFT, RIGHT], {(0, 1), (1, 3)})
    assert len(walls_between([LEFT, RIGHT], {(0, 1)})) == 1


def test_four_rooms_have_walls_that_leave_no_gap_at_the_crossing() -> None:
    outline, members = joined_floors(FOUR, 2) or pytest.fail("not joined")
    assert members == [0, 1, 2, 3]
    assert shapely.Polygon(outline).equals(shapely.box(0, 0, 6, 5))
    walls = walls_between(FOUR)
    # The longer one goes through, the others end at it.
    assert sorted(round(wall.length, 3) for wall in walls) == [2.1, 2.9, 6.0]
    made = [Partition(f"p{n}", wall.ends, wall.thickness) for n, wall in enumerate(walls)]
    assert not any(misplaced(one, outline) for one in made)
    built = [shapely.Polygon(w.to_plan(w.outline)) for w in partition_walls(made, outline)]
    free = shapely.box(0, 0, 6, 5).difference(shapely.union_all(built).buffer(1e-9))
    rooms = shapely.union_all([shapely.Polygon(floor) for floor in FOUR])
    assert free.symmetric_difference(rooms).area < 1e-3


def test_a_room_in_the_corner_of_another_has_two_walls_that_meet() -> None:
    ell = np.array([[0, 0], [6, 0], [6, 5], [3.3, 5], [3.3, 2], [0, 2]], float)
    floors = [ell, box(0, 2.3, 3, 5)]
    walls = walls_between(floors)
    ends = np.concatenate([wall.ends for wall in walls])
    assert len(walls) == 2
    corner = np.array([3.15, 2.15])
    assert (np.linalg.norm(ends - corner, axis=1) < 1e-9).sum() == 2
