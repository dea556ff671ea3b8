"""What is done to a plan, by identities of areas, lengths and places."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from openrooms_usd.building.shell import Hole
from openrooms_usd.description.layout import Opening
from openrooms_usd.errors import InputError
from openrooms_usd.view.plan.corners import (
    move_corner,
    move_wall,
    remove_corner,
    remove_wall,
    split_wall,
    square,
)
from openrooms_usd.view.plan.drawing import Drawing, Point
from openrooms_usd.view.plan.fittings import (
    add_opening,
    add_partition,
    hole_in,
    move_partition,
    remove_opening,
    remove_partition,
    set_opening,
)
from openrooms_usd.view.plan.session import History

BOX = ((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0))
L_SHAPE = ((0.0, 0.0), (6.0, 0.0), (6.0, 3.0), (4.2, 3.0), (4.2, 5.0), (0.0, 5.0))
SLANTED = ((0.0, 0.0), (5.0, 0.4), (4.6, 3.7), (1.0, 4.4), (-0.5, 2.0))


def plan_of(corners: Sequence[Point], walls: Sequence[int] = ()) -> Drawing:
    openings = tuple(
        Opening(kind="window", wall=wall, at=0.9, width=0.8, height=1.0, sill=0.9) for wall in walls
    )
    return Drawing(tuple(corners), 2.6, openings)


def places(plan: Drawing) -> list[np.ndarray]:
    """Where the middles of the openings are in the room."""
    found = []
    for one in plan.openings:
        start, end = plan.line(one)
        assert one.at is not None
        found.append(start + (end - start) / np.linalg.norm(end - start) * one.at)
    return found


def lengths(plan: Drawing) -> list[float]:
    return [float(np.linalg.norm(b - a)) for a, b in map(plan.ends, range(len(plan.corners)))]


def reversed_(corners: Sequence[Point]) -> tuple[Point, ...]:
    return tuple(corners[::-1])


@pytest.mark.parametrize("corners", [BOX, L_SHAPE, reversed_(BOX), reversed_(L_SHAPE)])
@pytest.mark.parametrize("by", [0.3, -0.25])
def test_a_wall_between_right_angles_changes_the_area_by_its_length_times_the_way(
    corners: Sequence[Point], by: float
) -> None:
    plan = plan_of(corners)
    for wall, length in enumerate(lengths(plan)):
        assert move_wall(plan, wall, by).area == pytest.approx(plan.area + by * length)


@pytest.mark.parametrize("corners", [SLANTED, reversed_(SLANTED)])
def test_a_slanted_room_changes_by_a_trapezium_and_keeps_all_directions(
    corners: Sequence[Point],
) -> None:
    plan, by = plan_of(corners), 0.2
    for wall in range(len(corners)):
        moved = move_wall(plan, wall, by)
        mean = 0.5 * (lengths(plan)[wall] + lengths(moved)[wall])
        assert moved.area == pytest.approx(plan.area + by * mean)
        for number in range(len(corners)):
            (a, b), (c, d) = plan.ends(number), moved.ends(number)
            cross = (b - a)[0] * (d - c)[1] - (b - a)[1] * (d - c)[0]
            assert abs(float(cross)) < 1e-9


def test_a_part_of_a_straight_wall_becomes_a_niche() -> None:
    plan = split_wall(split_wall(plan_of(BOX, [0]), 0, (3.0, 0.0)), 0, (2.0, 0.0))
    niche = move_wall(plan, 1, 0.3)
    assert len(niche.corners) == 8
    assert niche.area == pytest.approx(20.0 + 0.3)
    assert niche.openings[0].wall == 0
    assert move_wall(niche, 2, -0.3).area == pytest.approx(20.0)
    assert remove_wall(niche, 1).polygon == pytest.approx(np.array(BOX))


def test_a_step_that_is_left_out_goes_into_line_with_the_longer_wall() -> None:
    stepped = plan_of(((0, 0), (3, 0), (3, 0.3), (5, 0.3), (5, 4), (0, 4)))
    assert remove_wall(stepped, 1).polygon == pytest.approx(np.array(BOX))
    chamfered = plan_of(((0, 0), (5, 0), (5, 3), (4, 4), (0, 4)))
    assert remove_wall(chamfered, 2).polygon == pytest.approx(np.array(BOX))


@pytest.mark.parametrize("corners", [BOX, L_SHAPE, SLANTED, reversed_(SLANTED)])
@settings(max_examples=15)
@given(share=st.floats(0.01, 0.99))
def test_split_and_merged_is_as_before(corners: Sequence[Point], share: float) -> None:
    plan = plan_of(corners, range(len(corners)))
    for wall in range(len(corners)):
        start, end = plan.ends(wall)
        x, y = start + share * (end - start)
        split = split_wall(plan, wall, (float(x), float(y)))
        assert split.area == pytest.approx(plan.area)
        assert sum(lengths(split)) == pytest.approx(sum(lengths(plan)))
        assert np.allclose(places(split), places(plan))
        merged = remove_corner(split, wall + 1)
        assert merged.corners == plan.corners
        assert merged.as_section() == plan.as_section()


def test_openings_stay_where_they_are_in_the_room_when_a_wall_beside_them_moves() -> None:
    plan = plan_of(L_SHAPE, [1, 3, 5])
    moved = move_wall(plan, 0, 0.7)
    assert np.allclose(places(moved), places(plan))
    assert [one.wall for one in moved.openings] == [1, 3, 5]
    assert moved.openings[0].at == pytest.approx(0.9 + 0.7)


@pytest.mark.parametrize("corner", range(6))
def test_a_corner_that_is_left_out_takes_no_opening_with_it(corner: int) -> None:
    plan = plan_of(L_SHAPE, range(6))
    fewer = remove_corner(plan, corner)
    assert len(fewer.openings) == 6 and len(fewer.corners) == 5
    kept = [i for i in range(6) if i not in (corner, (corner - 1) % 6)]
    assert np.allclose([places(fewer)[i] for i in kept], [places(plan)[i] for i in kept])


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.2])
def test_a_dragged_corner_snaps_to_right_angles_whatever_the_room_s_direction(turn: float) -> None:
    c, s = math.cos(turn), math.sin(turn)
    corners = [(c * x - s * y, s * x + c * y) for x, y in L_SHAPE]
    off = plan_of([*corners[:2], (corners[2][0] + 0.3, corners[2][1] - 0.2), *corners[3:]])
    near = (corners[2][0] + 0.05, corners[2][1] + 0.04)
    assert move_corner(off, 2, near, snap=True).corners[2] == pytest.approx(corners[2])
    assert move_corner(off, 2, near).corners[2] == pytest.approx(near)
    far = (corners[2][0] + 0.31, corners[2][1] + 0.33)
    assert np.linalg.norm(np.subtract(move_corner(off, 2, far, snap=True).corners[2], far)) < 0.13


def test_a_dragged_wall_snaps_into_line_with_another() -> None:
    plan = plan_of(L_SHAPE)
    assert move_wall(plan, 2, 1.93, snap=True).corners[2] == pytest.approx((6.0, 5.0))


def test_squared_up_every_wall_runs_along_or_across_and_oblique_ones_stay() -> None:
    rng = np.random.default_rng(3)
    corners = np.asarray(L_SHAPE) + rng.normal(0.0, 0.04, (6, 2))
    made = square(plan_of([(float(x), float(y)) for x, y in corners]))
    steps = np.roll(made.polygon, -1, axis=0) - made.polygon
    angles = np.degrees(np.arctan2(steps[:, 1], steps[:, 0])) % 90.0
    apart = (angles - angles[0] + 45.0) % 90.0 - 45.0
    assert np.abs(apart).max() < 1e-6
    assert np.abs(made.polygon - corners).max() < 0.2
    slanted = square(plan_of(((0, 0), (5, 0.02), (5, 3), (4, 4), (0, 4))))
    step = slanted.polygon[3] - slanted.polygon[2]
    assert math.degrees(math.atan2(step[1], step[0])) == pytest.approx(135.0, abs=1.0)


@pytest.mark.parametrize("corners", [BOX, reversed_(BOX)])
def test_an_opening_is_where_its_rectangle_is_seen_from_inside(corners: Sequence[Point]) -> None:
    plan = plan_of(corners)
    for wall in range(4):
        made = add_opening(plan, Hole(0.5, 1.7, 0.9, 2.1), wall=wall)
        assert made.openings[0].kind == "window"
        seen = plan.seen(wall)
        assert places(made)[0] == pytest.approx(seen.to_plan(np.array([1.1, 0.0])))
        hole = hole_in(made, made.openings[0])
        assert (hole.left, hole.right, hole.bottom, hole.top) == pytest.approx((0.5, 1.7, 0.9, 2.1))


def test_what_reaches_the_floor_is_a_door_and_snaps_to_it() -> None:
    made = add_opening(plan_of(BOX), Hole(-0.4, 1.0, 0.05, 2.9), wall=0, snap=True)
    hole = hole_in(made, made.openings[0])
    assert made.openings[0].kind == "door"
    assert (hole.left, hole.right, hole.bottom, hole.top) == pytest.approx((0.02, 1.0, 0.0, 2.58))
    wide = set_opening(made, 0, hole=Hole(1.0, 2.0, 0.0, 2.0), kind="opening")
    assert (wide.openings[0].kind, wide.openings[0].width) == ("opening", 1.0)
    assert remove_opening(wide, 0) == plan_of(BOX)


def test_partitions_keep_their_names_and_take_their_openings_with_them() -> None:
    plan = add_partition(add_partition(plan_of(BOX), ((1, 0), (1, 4))), ((3, 0), (3, 4)))
    plan = add_opening(plan, Hole(0.5, 1.4, 0.0, 2.0), partition="partition_1")
    plan = move_partition(plan, 1, ((3.5, 0), (3.5, 4)))
    assert places(plan)[0] == pytest.approx((3.5, 0.95))
    fewer = remove_partition(plan, 0)
    assert [one.name for one in fewer.partitions] == ["partition_1"]
    assert len(fewer.openings) == 1
    assert remove_partition(fewer, 0).openings == ()


def test_what_is_undone_is_exactly_what_was() -> None:
    plan = plan_of(SLANTED, [0, 2])
    history = History(plan)
    for wall in range(5):
        history.do(move_wall(history.now, wall, 0.1))
    written = history.now.as_section()
    for _ in range(9):
        history.undo()
    assert (history.now, history.done, history.undone) == (plan, 0, 5)
    for _ in range(9):
        history.redo()
    assert history.now.as_section() == written and history.undone == 0
    history.undo()
    history.do(plan)
    assert (history.done, history.undone) == (5, 0)


@pytest.mark.parametrize(
    "change",
    [
        lambda plan: move_corner(plan, 4, (0, 0)),
        lambda plan: move_wall(plan, 9, 1.0),
        lambda plan: add_opening(plan, Hole(0, 1, 0, 2), partition="screen"),
        lambda plan: set_opening(plan, 0, kind="door"),
        lambda plan: remove_corner(remove_corner(plan, 0), 0),
        lambda plan: add_opening(plan, Hole(0, 0.01, 0, 2), wall=0),
    ],
)
def test_what_is_not_there_is_refused(change: object) -> None:
    with pytest.raises(InputError):
        change(plan_of(BOX))  # type: ignore[operator]
