"""Scores of scans have the values of their definitions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.results import FoundObject, FoundOpening, FoundRoom, Pose

SQUARE = np.array([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0.0]])


def opening(x=1.0, width=1.0, low=0.0, high=2.0, y=0.0, kind="door"):
    """A hole in the wall at y = 0: seen from inside, the right is towards -x."""
    a, b = x + width, x
    ring = np.array([[a, y, low], [b, y, low], [b, y, high], [a, y, high]])
    return FoundOpening(kind, ring, 1.0, 0)


def room(corners=SQUARE, **values):
    up = np.array([0, 0, 1.0])
    return FoundRoom(up, np.asarray(corners)[0], np.asarray(corners, float), **values)


def test_what_is_true_scores_full():
    from benchmarks.scan.scores import Counts, score_room

    true = room(ceiling=2.5, openings=(opening(), opening(2.5, kind="window", low=1)))
    score = score_room(true, true)
    assert (score.floor_degrees, score.floor_offset, score.ceiling) == (0, 0, 0)
    assert score.iou == pytest.approx(1)
    assert score.corners == score.edges == Counts(4, 4, 4)
    assert score.openings == Counts(2, 2, 2)


def test_a_rigid_motion_of_both_changes_no_score():
    from benchmarks.scan.scores import score_room
    from benchmarks.scan.truth import Truth

    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", [8, -5, 33], degrees=True).as_matrix()
    matrix[:3, 3] = (1e3, -20, 7)
    true = room(ceiling=2.5, openings=(opening(),))
    found = room(
        SQUARE + np.array([[0, 0, 0], [0.2, 0, 0], [0, 0, 0], [0, 0.05, 0]]),
        openings=(opening(1.2),),
    )
    one = score_room(found, true)
    a, b = (Truth((item,), (), {}).moved(matrix).rooms[0] for item in (found, true))
    two = score_room(a, b)
    assert two.iou == pytest.approx(one.iou)
    assert (two.corners, two.edges, two.openings) == (one.corners, one.edges, one.openings)
    assert two.floor_offset == pytest.approx(0, abs=1e-9)


def test_room_iou_of_overlapping_rectangles():
    from benchmarks.scan.scores import iou

    a = np.array([[0, 0], [4, 0], [4, 3], [0, 3.0]])
    assert iou(a, a + np.array([1, 0])) == pytest.approx(9 / 15)
    assert iou(a, a[::-1]) == pytest.approx(1)
    assert iou(a, a + 10) == 0


def test_corners_count_once_and_edges_need_both_of_theirs():
    from benchmarks.scan.scores import Counts, corner_counts

    true = SQUARE[:, :2]
    moved = true.copy()
    moved[1] += (0.11, 0)
    assert corner_counts(moved, true) == (Counts(3, 4, 4), Counts(2, 4, 4))
    moved[1] = true[1] + (0.09, 0)
    assert corner_counts(moved, true)[0].hits == 4
    # A second corner beside a true one is one too many, and splits no edge in two.
    extra = np.insert(true, 1, (0.05, 0.0), axis=0)
    corners, edges = corner_counts(extra, true)
    assert corners == Counts(4, 5, 4) and edges == Counts(3, 5, 4)
    # A diagonal joins two true corners, and is no edge.
    assert corner_counts(true[:3], true)[1] == Counts(2, 3, 4)
    # A corner in the middle of a wall parts the edge.
    halved = np.insert(true, 1, (2.0, 0.0), axis=0)
    assert corner_counts(halved, true)[1] == Counts(3, 5, 4)


def test_floor_error_is_an_angle_and_a_distance_at_the_middle():
    from benchmarks.scan.scores import floor_error

    tilt = np.radians(1.0)
    found = replace(room(), normal=np.array([np.sin(tilt), 0, np.cos(tilt)]))
    degrees, offset = floor_error(found, room())
    assert degrees == pytest.approx(1.0)
    # The plane through the corner (0, 0, 0), two metres from the middle along x.
    assert offset == pytest.approx(2 * np.tan(tilt))


@pytest.mark.parametrize(
    ("found", "hits"),
    [
        (opening(1.3), 1),  # IoU 0.7 / 1.3
        (opening(1.35), 0),  # IoU 0.65 / 1.35
        (opening(kind="window"), 0),
        (opening(y=0.25), 1),
        (opening(y=0.35), 0),
        (opening(high=1.1), 1),
        (opening(high=0.9), 0),
    ],
)
def test_openings_count_from_half_an_iou_on_their_wall(found, hits):
    from benchmarks.scan.scores import opening_counts

    assert opening_counts([found], [opening()]).hits == hits
    assert opening_counts([found, found], [opening()]).hits == hits


def pose(degrees=0.0, scale=(1, 1, 1), at=(0, 0, 0)):
    turn = Rotation.from_euler("z", degrees, degrees=True).as_quat(scalar_first=True)
    return Pose(np.asarray(at, float), turn, np.asarray(scale, float))


@pytest.mark.parametrize(
    ("symmetry", "turn", "error"),
    [("none", 170, 170), ("2", 170, 10), ("4", 80, 10), ("inf", 123, 0), ("4", 45, 45)],
)
def test_rotations_count_up_to_the_symmetry(symmetry, turn, error):
    from benchmarks.scan.pose_sections import pose_error

    assert pose_error(pose(turn), pose(), symmetry).degrees == pytest.approx(error, abs=1e-6)


def test_scales_follow_the_axes_through_a_quarter_turn():
    from benchmarks.scan.pose_sections import pose_error

    turned = pose_error(pose(90, (2, 1, 1)), pose(0, (1, 2, 1)), "4")
    assert turned.axis_scale == pytest.approx(0)
    straight = pose_error(pose(0, (2, 1, 1)), pose(0, (1, 2, 1)), "none")
    assert straight.axis_scale == pytest.approx(1)


def test_errors_of_scale_cancel_by_the_rule_of_scan2cad_but_not_by_the_tight_one():
    from benchmarks.scan.pose_sections import SCAN2CAD, TIGHT, pose_error

    error = pose_error(pose(scale=(1.3, 0.7, 1.0)), pose(), "none")
    assert error.within(SCAN2CAD) and not error.within(TIGHT)
    assert error.mean_scale == pytest.approx(0) and error.axis_scale == pytest.approx(0.3)
    assert pose_error(pose(4.9, at=(0.04, 0.02, 0)), pose(), "none").within(TIGHT)
    assert not pose_error(pose(5.1), pose(), "none").within(TIGHT)


def test_objects_that_were_not_found_or_of_another_cad_fail():
    from benchmarks.scan.pose_sections import pose_summary, score_objects

    def item(number, cad="a", at=(0, 0, 0), placed=None):
        return FoundObject(number, "chair", cad, pose(at=at), 0, 1, placed=placed)

    true = [item(1), item(2), item(3), item(4)]
    found = [item(1), item(2, at=(0.1, 0, 0), placed=pose()), item(3, "b")]
    summary = pose_summary(score_objects(found, true))
    assert summary["objects"] == 4 and summary["found"] == 0.5
    assert (summary["scan2cad"], summary["tight"], summary["tight_placed"]) == (0.5, 0.25, 0.5)
