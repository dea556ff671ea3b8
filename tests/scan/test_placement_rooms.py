"""What carries objects where that is known or doubtful, and whole rooms: once is enough."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.placement.correcting import Placement, correction, place
from openrooms_usd.scan.results import FoundObject, Pose
from tests.scan.placement_cases import MODELS, found, outside, overlaps, points, room, shifts

TABLE = found(1, "table", (2, 1.5, 0))


def run(*items: FoundObject, home=None) -> Placement:
    return place(items, MODELS, [home or room()])


def lowest(item: FoundObject) -> float:
    return float(points(item)[:, 2].min())


@pytest.mark.parametrize(
    ("shape", "at", "given", "carries"),
    [
        ("box", (2, 1.5, 0.1), "1", 0.74),  # measured inside of the table
        ("box", (2.68, 1.5, 0.9), "1", 0.74),  # and beside it
        ("box", (2, 1.5, 0.76), "floor", 0.0),
        ("wardrobe", (1, 1.0, 0.7), "floor", 0.0),
        ("ceiling_lamp", (1, 1.0, 1.6), "ceiling", 1.8),
    ],
)
def test_a_support_that_is_known_is_where_things_go(shape, at, given, carries) -> None:
    result = run(TABLE, found(2, shape, at, support=given))
    assert result.objects[1].support == given
    assert lowest(result.objects[1]) == pytest.approx(carries, abs=1e-9)


def test_a_picture_is_known_to_hang_though_something_is_just_below() -> None:
    picture = found(2, "picture", (2, 2.9, 0.95), support="wall")
    result = run(found(1, "table", (2, 2.6, 0)), picture)
    assert result.objects[1].support == "wall"
    assert points(result.objects[1])[:, 1].max() == pytest.approx(3.0, abs=1e-3)
    assert shifts(result)[2][2] == 0.0


def test_supports_that_cannot_be_are_told() -> None:
    box, other = found(2, "box", (1, 1.5, 0), support="3"), found(3, "box", (1, 1.5, 0.25))
    missing = run(found(2, "box", (1, 1.5, 0.01), support="9"))
    assert missing.notes == ("instance 2 cannot stand on 9, which was not found",)
    assert missing.objects[0].support == "floor"
    circle = run(box, replace(other, support="2"))
    assert circle.notes == ("instance 3 cannot stand on 2, which stands on it",)


def test_a_television_hangs_above_a_board_and_stands_on_it() -> None:
    board = found(1, "counter", (2, 2.7, 0))
    hung = run(board, found(2, "television", (2, 2.965, 1.0)))
    assert [item.support for item in hung.objects] == ["floor", "wall"]
    assert shifts(hung)[2][2] == 0.0
    stood = run(board, found(2, "television", (2, 2.9, 0.93)))
    assert stood.objects[1].support == "1"
    assert lowest(stood.objects[1]) == pytest.approx(0.9, abs=1e-9)


@pytest.mark.parametrize("height", [0.021, 0.0, 0.035])
def test_a_carton_stands_on_the_lowest_board_of_a_shelf_not_on_the_floor(height: float) -> None:
    low = np.array([1.0, 1.0, 0.3])  # the board's top is 2.1 cm high
    items = [found(1, "bookshelf", (2, 2.8, 0)), found(2, "box", (2.1, 2.8, height))]
    items = [replace(item, pose=replace(item.pose, scale=low)) for item in items]
    result = run(*items)
    assert result.objects[1].support == "1"
    assert lowest(result.objects[1]) == pytest.approx(0.021, abs=1e-9 + 0.002 * (height == 0.021))
    assert not result.unresolved


@pytest.mark.parametrize("height", [0.15, 0.3])
def test_what_never_hangs_comes_down_beside_a_wall(height: float) -> None:
    result = run(found(1, "floor_lamp", (0.16, 1.5, height)))
    assert result.objects[0].support == "floor"
    assert lowest(result.objects[0]) == pytest.approx(0.0, abs=1e-9)


def test_a_lamp_far_below_the_ceiling_stays_and_is_reported() -> None:
    result = run(found(1, "ceiling_lamp", (2, 1.5, 1.9)))
    assert result.objects[0].placed is result.objects[0].pose
    (left,) = result.unresolved
    assert (left.kind, left.depth) == ("floats", pytest.approx(0.6))


def test_furniture_does_not_go_along_with_its_rug() -> None:
    # The rug is 20 cm in the wall; the table and its chair are where they should be.
    rug = found(1, "rug", (0.6, 1.5, 0))
    table = found(2, "table", (0.65, 1.5, 0.012))
    lamp = found(3, "table_lamp", (0.65, 1.5, 0.752))
    result = run(rug, table, lamp)
    assert not result.unresolved
    moved = shifts(result)
    assert moved[1][0] == pytest.approx(0.2, abs=1e-3)
    np.testing.assert_allclose([moved[2], moved[3]], 0.0, atol=1e-9)
    assert result.objects[1].support == "1"


def test_what_loses_its_rug_stands_on_the_floor() -> None:
    result = run(found(1, "rug", (0.6, 1.5, 0)), found(2, "chair", (0.26, 1.5, 0.0)))
    assert not result.unresolved
    assert lowest(result.objects[1]) == pytest.approx(
        0.012 if result.objects[1].support == "1" else 0.0, abs=1e-9
    )


def test_counters_in_a_row_stay_together() -> None:
    row = [found(k + 1, "counter", (0.27 + 0.6 * k, 2.7, 0)) for k in range(4)]
    result = run(*row)
    assert not result.unresolved and not overlaps(result.objects)
    # The first is 3 cm in the wall: all move by that, and touch as before.
    for step in shifts(result).values():
        np.testing.assert_allclose(step, [0.03, 0, 0], atol=2e-3)


def test_what_touches_follows_one_that_goes_away() -> None:
    # The second is free to stay; it goes along with the first, which it touches.
    row = [found(1, "counter", (3.72, 2.7, 0)), found(2, "counter", (3.12, 2.7, 0))]
    right = found(3, "chair", (1, 1, 0))
    result = run(*row, right)
    np.testing.assert_allclose(shifts(result)[2], shifts(result)[1], atol=2e-3)
    assert result.objects[2].placed is right.pose


def test_the_free_corner_of_an_l_is_free() -> None:
    sofa = found(1, "sofa", (2, 1.5, 0))
    table = found(2, "box", (1.6, 1.1, 0))
    result = run(sofa, table)
    assert all(item.placed is item.pose for item in result.objects)
    assert not result.unresolved
    pushed = run(sofa, found(2, "box", (2.11, 1.1, 0)))
    assert not pushed.unresolved
    moved = shifts(pushed)
    np.testing.assert_allclose(moved[2] - moved[1], [-0.03, 0, 0], atol=2e-3)


def test_what_is_outside_or_too_large_is_reported_and_moves_nothing() -> None:
    # A box that is right, in the way of a wardrobe that is mostly outside.
    box = found(1, "box", (3.85, 1.5, 0))
    result = run(box, found(2, "wardrobe", (4.5, 1.5, 0)))
    assert all(item.placed is item.pose for item in result.objects)
    told = {(left.kind, left.instance, left.other): left.depth for left in result.unresolved}
    assert set(told) == {("in a wall", 2, None), ("overlaps", 2, 1)}
    assert told["in a wall", 2, None] == pytest.approx(1.1, abs=1e-6)
    # 4.5 m in a room of 4 m: 35 cm in one wall and 15 in the other; 25 each are no better.
    long = found(3, "table", (2.1, 1.5, 0))
    long = replace(long, pose=replace(long.pose, scale=np.array([3.75, 1.0, 1.0])))
    result = run(long)
    assert result.objects[0].placed is long.pose
    assert [(left.kind, left.instance) for left in result.unresolved] == [("in a wall", 3)]


def test_the_order_of_objects_changes_nothing() -> None:
    items = [
        found(1, "table", (3.55, 1.5, 0.03), yaw=4),
        found(2, "chair", (3.2, 1.2, 0), 170),
        found(3, "chair", (2.9, 1.3, 0.02), 20),
        found(4, "table_lamp", (3.5, 1.5, 0.8)),
        found(5, "rug", (3.0, 1.0, 0.01)),
        found(6, "counter", (0.2, 2.8, 0)),
        found(7, "counter", (0.75, 2.72, 0)),
    ]
    one = {item.instance: item for item in run(*items).objects}
    for seed in range(3):
        rows = np.random.default_rng(seed).permutation(len(items))
        result = run(*(items[row] for row in rows))
        assert [item.instance for item in result.objects] == [items[row].instance for row in rows]
        for item in result.objects:
            other = one[item.instance]
            assert np.array_equal(item.placed.translation, other.placed.translation)
            assert np.array_equal(item.placed.rotation, other.placed.rotation)
            assert item.support == other.support


@pytest.mark.parametrize(("word", "carrier"), [("radiator", "wall"), ("carton", "floor")])
def test_a_box_hangs_where_what_it_stands_for_does(word: str, carrier: str) -> None:
    thing = replace(found(1, "box", (2, 2.895, 0.15)), word=word)
    assert run(thing).objects[0].support == carrier


HALL = room([[0, 0], [9, 0], [9, 7], [0, 7]], ceiling=2.5)


def furnished() -> list[FoundObject]:
    """Fifty objects, all of them right."""
    items, number = [], iter(range(1, 100))
    for x in (1.5, 4.5, 7.5):
        for y in (1.5, 3.6):
            table = next(number)
            items.append(found(table, "table", (x, y, 0)))
            items.append(found(next(number), "table_lamp", (x, y, 0.74)))
            items.append(found(next(number), "chair", (x - 0.25, y - 0.5, 0), 180))
            items.append(found(next(number), "chair", (x + 0.25, y + 0.55, 0)))
            items.append(found(next(number), "ceiling_lamp", (x, y, 2.5)))
    for k in range(6):
        shelf = next(number)
        items.append(found(shelf, "bookshelf", (1.0 + 1.05 * k, 6.85, 0)))
        items.append(found(next(number), "box", (1.0 + 1.05 * k, 6.85, 0.47)))
        items.append(found(next(number), "box", (1.1 + 1.05 * k, 6.85, 1.2)))
    items.append(found(next(number), "wardrobe", (8.7, 5.5, 0), 90))
    items.append(found(next(number), "picture", (4.5, 0.012, 1.5)))
    assert len(items) == 50
    return items


def disturbed(items: list[FoundObject], seed: int) -> list[FoundObject]:
    rng, moved = np.random.default_rng(seed), []
    for item in items:
        turn = Rotation.from_rotvec(np.radians(rng.normal(0, [0.7, 0.7, 2.5])))
        turn = turn * Rotation.from_quat(item.pose.rotation, scalar_first=True)
        place_ = item.pose.translation + rng.normal(0, [0.03, 0.03, 0.02])
        pose = Pose(place_, turn.as_quat(canonical=True, scalar_first=True), item.pose.scale)
        moved.append(replace(item, pose=pose))
    return moved


def tight(result: Placement, truth: list[FoundObject], which: str) -> float:
    """The part of the objects within 5 cm and 5 degrees of the truth."""
    good = []
    for item, right in zip(result.objects, truth, strict=True):
        pose = getattr(item, which)
        off = np.linalg.norm(pose.translation - right.pose.translation)
        turn = Rotation.from_quat(pose.rotation, scalar_first=True)
        turn = turn * Rotation.from_quat(right.pose.rotation, scalar_first=True).inv()
        good.append(off < 0.05 and np.degrees(turn.magnitude()) < 5)
    return float(np.mean(good))


def test_a_good_room_stays_to_the_bit() -> None:
    result = place(furnished(), MODELS, [HALL])
    assert not result.unresolved and not result.notes
    assert all(item.placed is item.pose for item in result.objects)
    on = [item.support for item in result.objects]
    assert [on.count(kind) for kind in ("floor", "wall", "ceiling")] == [25, 1, 6]


@cache
def settled() -> Placement:
    return place(disturbed(furnished(), 1), MODELS, [HALL])


@pytest.mark.slow
def test_fifty_disturbed_objects() -> None:
    truth, result = furnished(), settled()
    before = disturbed(truth, 1)
    assert len(overlaps(before)) > 3
    assert not overlaps(result.objects) and not result.unresolved
    assert max(outside(item, HALL) for item in result.objects) < 0.01
    for item in result.objects:
        low = float(points(item)[:, 2].min())
        if item.support == "floor":
            assert low == pytest.approx(0.0, abs=0.01)
    assert tight(result, truth, "placed") >= tight(result, truth, "pose") + 0.05
    assert [result.objects[row].support for row in (0, 1, 2, 31)] == ["floor", "1", "floor", "31"]
    assert max(np.linalg.norm(step[:2]) for step in shifts(result).values()) < 0.2


def test_placing_twice_changes_nothing() -> None:
    again = [replace(item, pose=item.placed, placed=None, support="") for item in settled().objects]
    twice = place(again, MODELS, [HALL])
    assert all(item.placed is item.pose for item in twice.objects)


def test_the_same_input_gives_the_same_bits_and_names_do_not_matter() -> None:
    items = disturbed(furnished()[:12], 4)
    one = place(items, MODELS, [HALL])
    two = place([replace(item, instance=item.instance + 1000) for item in items], MODELS, [HALL])
    for a, b in zip(one.objects, two.objects, strict=True):
        assert np.array_equal(a.placed.translation, b.placed.translation)
        assert np.array_equal(a.placed.rotation, b.placed.rotation)


def test_the_correction_takes_the_measured_pose_to_the_placed_one() -> None:
    for item in settled().objects:
        motion, cloud = correction(item), MODELS[item.cad].vertices
        turn = Rotation.from_quat(item.pose.rotation, scalar_first=True).as_matrix()
        measured = cloud @ turn.T + item.pose.translation
        np.testing.assert_allclose(
            measured @ motion[:3, :3].T + motion[:3, 3], points(item), atol=1e-12
        )
        np.testing.assert_allclose(motion[:3, :3] @ motion[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.array_equal(item.placed.scale, item.pose.scale)


def test_nothing_to_place() -> None:
    assert place([], MODELS, [HALL]) == Placement((), (), (), ())
    alone = place([found(1, "table", (0, 0, 0.03))], MODELS, [])
    np.testing.assert_allclose(alone.objects[0].placed.translation, 0.0, atol=1e-9)


def test_a_level_turn_of_the_whole_room_changes_nothing_but_the_frame() -> None:
    """Two chairs in each other and a table in a wall, in a room turned by 37 degrees."""
    turn = Rotation.from_euler("z", 37, degrees=True)
    items = [
        found(1, "chair", (2, 1.5, 0)),
        found(2, "chair", (2.38, 1.5, 0)),
        found(3, "table", (8.5, 3, 0)),
    ]
    turned = [
        replace(
            item,
            pose=Pose(
                turn.apply(item.pose.translation),
                (turn * Rotation.from_quat(item.pose.rotation, scalar_first=True)).as_quat(
                    scalar_first=True
                ),
                item.pose.scale,
            ),
        )
        for item in items
    ]
    home = replace(HALL, corners=turn.apply(HALL.corners))
    straight, slanted = place(items, MODELS, [HALL]), place(turned, MODELS, [home])
    for a, b in zip(straight.objects, slanted.objects, strict=True):
        np.testing.assert_allclose(
            turn.apply(a.placed.translation), b.placed.translation, atol=2e-3
        )
