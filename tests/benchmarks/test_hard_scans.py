"""Hard scans are as hard as they say, and simple fits have the answers of simple cases."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.results import Pose

pytest.importorskip("embreex")


def test_every_hard_case_that_is_asked_for_is_there():
    from benchmarks.scan.hard_scans import CASES

    text = " ".join(CASES)
    for word in (
        "empty", "one wall", "12 x 1.5", "2 m", "15 m", "bay", "mirrors", "30 %", "20 % wrong",
        "no labels", "1e6", "millimetres", "100:1", "NaN", "10 degrees", "one view", "symmetric",
        "under a table", "stacked", "through a wall",
    ):  # fmt: skip
        assert word in text


@pytest.fixture(scope="module")
def small():
    """The usual scan of hard cases, made once with few rays."""
    from dataclasses import replace

    from benchmarks.scan import hard_rooms, hard_scans

    usual, hard_rooms.QUICK = hard_rooms.QUICK, replace(hard_rooms.QUICK, frames=8, reduce=10)
    hard_scans.usual.cache_clear()
    yield hard_scans.CASES
    hard_rooms.QUICK = usual
    hard_scans.usual.cache_clear()


def test_bad_numbers_units_and_places(small):
    usual = small["30 % outliers"](1).scan
    count = len(usual.cloud)
    broken = small["duplicates and NaN"](1).scan.cloud.points
    finite = broken[np.isfinite(broken).all(axis=1)]
    assert 0.003 < 1 - len(finite) / len(broken) < 0.02
    assert len(broken) == pytest.approx(1.2 * count, rel=0.001)
    assert len(np.unique(finite, axis=0)) < len(finite) - 0.1 * count
    far = small["coordinates at 1e6 m"](1).scan
    assert np.abs(far.cloud.points[:, 0]).min() > 1e6
    assert far.truth.rooms[0].corners[:, 0].min() == pytest.approx(1.2e6)
    thousand = small["millimetres"](1)
    near = far.cloud.points - far.truth.rooms[0].corners[0]
    assert np.allclose(thousand.scan.cloud.points * thousand.unit, near, atol=1e-6)
    assert len(small["empty cloud"](1).scan.cloud) == 0
    assert (small["one wall"](1).scan.cloud.points[:, 1] > 3.94).all()


def test_outliers_labels_and_tilt_are_as_large_as_they_say(small):
    outliers = small["30 % outliers"](1).scan
    points, (low, high) = outliers.cloud.points, ((-0.3, -0.3, -0.1), (5.3, 4.3, 2.6))
    outside = ((points < low) | (points > high)).any(axis=1).mean()
    volume = 1 - (5.6 * 4.6 * 2.7) / np.prod(np.ptp(points, axis=0))
    assert outside == pytest.approx(0.3 * volume, abs=0.03)
    assert small["no labels"](1).scan.cloud.label is None
    normal = small["tilt of 10 degrees"](1).scan.truth.rooms[0].normal
    assert np.degrees(np.arccos(normal[2])) == pytest.approx(10)


def test_holes_of_built_rooms_are_holes_and_objects_stand_where_they_should():
    from benchmarks.scan.built import built
    from benchmarks.scan.hard_rooms import DOOR, LIVING, WINDOW, rectangle
    from openrooms_usd.geometry.raycast import RayCaster

    room = built(rectangle(5, 4), holes=(DOOR, WINDOW), things=LIVING)
    caster = RayCaster(room.points, room.triangles)
    for hole in room.truth.rooms[0].openings:
        middle = hole.corners.mean(axis=0)
        inward = np.cross(hole.corners[1] - hole.corners[0], hole.corners[3] - hole.corners[0])
        inward /= np.linalg.norm(inward)
        assert (np.array([2.5, 2.0, 1.2]) - middle) @ inward > 0
        assert not caster.occluded(middle + 0.1 * inward, -inward, 0.25)[0]
        beside = middle + (hole.corners[1] - hole.corners[0]) * 0.6
        assert caster.occluded(beside + 0.1 * inward, -inward, 0.25)[0]
    down = caster.first_hit(np.array([[2.5, 2.0, 2.0]]), np.array([[0, 0, -1.0]]))
    assert down.distance[0] == pytest.approx(2.0 - 0.74)


def posed(points, pose):
    turn = Rotation.from_quat(pose.rotation, scalar_first=True)
    return turn.apply(points * pose.scale) + pose.translation


@pytest.fixture(scope="module")
def sofa():
    """A model, its true pose, and points on it."""
    from benchmarks.scan.built import CADS
    from benchmarks.scan.pose_baselines import samples

    turn = Rotation.from_euler("z", 40, degrees=True).as_quat(scalar_first=True)
    pose = Pose(np.array([1.0, 2.0, 0.0]), turn, np.ones(3))
    return CADS["sofa"], pose, posed(samples(CADS["sofa"], 3000), pose)


@pytest.mark.slow
def test_fits_from_a_near_start_find_a_fully_seen_object(sofa):
    from benchmarks.scan.pose_baselines import icp, seven_degrees
    from benchmarks.scan.pose_scores import TIGHT, pose_error

    cad, true, points = sofa
    turn = Rotation.from_euler("z", 44, degrees=True).as_quat(scalar_first=True)
    near = Pose(
        true.translation + np.array([0.04, -0.03, 0.02]), turn, np.array([1.04, 0.97, 1.03])
    )
    rigid = Pose(near.translation, near.rotation, np.ones(3))
    assert pose_error(icp(points, cad, rigid), true, "none").within(TIGHT)
    assert pose_error(seven_degrees(points, cad, near), true, "none").within(TIGHT)


@pytest.mark.parametrize("quarter", [0, 1, 2, 3])
def test_the_grid_finds_the_heading_in_the_right_box(sofa, quarter):
    from benchmarks.scan.pose_baselines import grid_in_box
    from benchmarks.scan.pose_scores import SCAN2CAD, pose_error
    from openrooms_usd.scan.registration.hypotheses import Box

    cad, true, points = sofa
    size = np.array([1.8, 0.8, 0.85])
    turn = Rotation.from_euler("z", 40 + 90 * quarter, degrees=True).as_quat(scalar_first=True)
    box = Box(np.array([1, 2, 0.425]), size[[1, 0, 2]] if quarter % 2 else size, turn)
    assert pose_error(grid_in_box(points, cad, box), true, "none").within(SCAN2CAD)


def test_a_manhattan_room_is_found_by_histograms():
    import trimesh

    from benchmarks.scan.baselines import manhattan
    from benchmarks.scan.scores import iou
    from openrooms_usd.scan.points.cloud import Cloud

    shell = trimesh.creation.box(bounds=[(0, 0, 0), (5, 4, 2.5)])
    points, faces = trimesh.sample.sample_surface(shell, 60_000, seed=1)
    turn = Rotation.from_euler("z", 23, degrees=True)
    cloud = Cloud(turn.apply(points), normals=turn.apply(-shell.face_normals[faces]))
    found = manhattan(cloud)
    expected = turn.apply([(0, 0, 0), (5, 0, 0), (5, 4, 0), (0, 4, 0)])[:, :2]
    assert iou(found.corners[:, :2], expected) > 0.985
    assert found.ceiling == pytest.approx(2.5, abs=0.03)


def test_rough_hints_have_the_noise_that_they_say():
    from benchmarks.scan.built import built
    from benchmarks.scan.hard_rooms import LIVING, rectangle
    from benchmarks.scan.hints import rough, stretched

    truth = stretched(built(rectangle(5, 4), things=LIVING).truth, 3)
    shifts, turns, scales = [], [], []
    for seed in range(200):
        for hint, item in zip(
            rough(truth.objects, truth.cads, seed, "pose"), truth.objects, strict=True
        ):
            shifts.append(hint.pose.translation - item.pose.translation)
            a, b = (
                Rotation.from_quat(p.rotation, scalar_first=True) for p in (hint.pose, item.pose)
            )
            turns.append((a * b.inv()).as_rotvec(degrees=True)[2])
            scales.append(np.log(hint.pose.scale / item.pose.scale))
    assert np.std(shifts) == pytest.approx(0.10, rel=0.1)
    assert np.std(turns) == pytest.approx(10, rel=0.1)
    assert np.std(scales) == pytest.approx(0.10, rel=0.1)


def test_development_and_test_seeds_are_apart():
    from benchmarks.scan.cases import rooms_of

    assert not set(rooms_of("development", False)) & set(rooms_of("test", False))
