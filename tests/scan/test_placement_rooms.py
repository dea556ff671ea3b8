"""Whole rooms: what is right stays to the bit, what is not is put right, and once is enough."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.placement.correcting import Placement, correction, place
from openrooms_usd.scan.results import FoundObject, Pose
from tests.scan.placement_cases import MODELS, found, outside, overlaps, points, room, shifts

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
