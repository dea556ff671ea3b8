"""Scores of real captures have the values of their definitions, and planted errors show."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

UNIT = {"origin": [0, 0, 0], "x": [1, 0, 0], "y": [0, 1, 0], "up": [0, 0, 1]}
SQUARE = [[0, 0], [4, 0], [4, 3], [0, 3]]


def door(x=1.0, width=1.0, top=2.0, **values):
    return {
        "type": "door",
        "segment": [[x, 0], [x + width, 0]],
        "bottom": 0.0,
        "top": top,
        "certain": True,
        **values,
    }


def written(folder: Path, name: str = "room", **values) -> Path:
    """A truth file: one room of 4 m by 3 m."""
    rooms = [{"name": "main", "polygon": SQUARE, "openings": [door()], "ceiling_height": 2.5}]
    raw = {"up_axis": "z", "unit_m": 1.0, "frame": UNIT, "rooms": rooms, "objects": [], **values}
    path = folder / f"{name}.json"
    path.write_text(json.dumps(raw))
    return path


def found(outline=SQUARE, openings=(), **values):
    """A room of a report."""
    corners = [[x, y, 0.0] for x, y in outline]
    floor = {"normal": [0, 0, 1], "point": [0, 0, 0]}
    return {"corners": corners, "openings": list(openings), "floor": floor, **values}


def hole(x=1.0, width=1.0, top=2.0, kind="door", y=0.0, confidence=0.9, bottom=0.0):
    ring = [[x, y, bottom], [x + width, y, bottom], [x + width, y, top], [x, y, top]]
    return {"type": kind, "corners": ring, "confidence": confidence, "wall": 0}


@pytest.fixture
def truth(tmp_path):
    from benchmarks.real.truth import truth_of

    return truth_of(written(tmp_path))


def test_what_is_true_scores_full(truth):
    from benchmarks.real.plans import plan_score
    from benchmarks.scan.scores import Counts

    score = plan_score([found(openings=[hole()], ceiling_height=2.4)], truth)
    assert score.iou == pytest.approx(1)
    assert score.corners == Counts(4, 4, 4)
    assert score.openings.typed == score.openings.untyped == Counts(1, 1, 1)
    assert score.openings.calibration.gap == pytest.approx(0.9 - 1)
    assert score.ceiling == pytest.approx(0.1)


def test_corners_count_within_twenty_centimetres_and_iou_is_of_areas(truth):
    from benchmarks.real.plans import plan_score
    from benchmarks.scan.scores import Counts

    near, far = (plan_score([found([*SQUARE[:2], [x, 3], [0, 3]])], truth) for x in (4.19, 4.21))
    assert near.corners == Counts(4, 4, 4)
    assert far.corners == Counts(3, 4, 4)
    wide = plan_score([found([[0, 0], [5, 0], [5, 3], [0, 3]])], truth)
    assert wide.iou == pytest.approx(4 / 5)
    assert wide.corners == Counts(2, 4, 4)


def test_the_outline_that_fits_best_counts(tmp_path):
    from benchmarks.real.plans import plan_score
    from benchmarks.real.truth import truth_of

    narrow = [[0, 0], [2, 0], [2, 3], [0, 3]]
    room = {"name": "main", "polygon": SQUARE, "alternatives": [narrow], "openings": None}
    score = plan_score([found(narrow)], truth_of(written(tmp_path, rooms=[room])))
    assert score.iou == pytest.approx(1)
    assert score.openings is None


def test_the_frame_of_the_truth_may_be_any(tmp_path):
    from benchmarks.real.plans import plan_score
    from benchmarks.real.running import ON_ITS_SIDE
    from benchmarks.real.truth import truth_of

    truth = truth_of(written(tmp_path))
    turned = replace(truth, frame=truth.frame.turned(ON_ITS_SIDE))
    raw = found(openings=[hole()])
    raw["corners"] = (np.array(raw["corners"]) @ ON_ITS_SIDE.T).tolist()
    raw["openings"][0]["corners"] = (
        np.array(raw["openings"][0]["corners"]) @ ON_ITS_SIDE.T
    ).tolist()
    one, two = plan_score([found(openings=[hole()])], truth), plan_score([raw], turned)
    assert two.iou == pytest.approx(one.iou)
    assert (two.corners, two.openings) == (one.corners, one.openings)


def test_the_overlap_of_openings_is_that_of_rectangles():
    from benchmarks.real.plans import overlap
    from benchmarks.real.truth import Hole

    true = Hole("door", ((0, 0), (1, 0)), 0, 2)
    assert overlap(true, true) == pytest.approx((1, 1))
    half = replace(true, ends=((0.5, 0), (1.5, 0)))
    assert overlap(half, true) == pytest.approx((1 / 3, 1 / 2))
    assert overlap(replace(true, ends=((1, 0), (0, 0))), true) == pytest.approx((1, 1))
    assert overlap(replace(true, top=1), true) == pytest.approx((1 / 2, 1))
    assert overlap(replace(true, ends=((0, 0.46), (1, 0.46))), true) == (0, 0)
    assert overlap(replace(true, ends=((0, 0), (0, 1))), true) == (0, 0)


@pytest.mark.parametrize(
    ("holes", "expected"),
    [
        ([hole(kind="window")], (0, 1, 1)),
        ([hole(), hole(x=1.02)], (1, 2, 1)),
        ([hole(x=2.5)], (0, 1, 1)),
        ([], (0, 0, 1)),
    ],
)
def test_wrong_openings_show(truth, holes, expected):
    from benchmarks.real.plans import plan_score
    from benchmarks.scan.scores import Counts

    assert plan_score([found(openings=holes)], truth).openings.typed == Counts(*expected)


def test_what_is_uncertain_counts_neither_way(tmp_path):
    from benchmarks.real.plans import plan_score
    from benchmarks.real.truth import truth_of
    from benchmarks.scan.scores import Counts

    holes = [door(), door(x=2.5, certain=False)]
    room = {"name": "main", "polygon": SQUARE, "openings": holes}
    truth = truth_of(written(tmp_path, rooms=[room]))
    score = plan_score([found(openings=[hole(), hole(x=2.5)])], truth)
    assert score.openings.typed == Counts(1, 1, 1)
    assert score.openings.calibration.claims == ((0.9, True),)


def test_claimed_confidence_is_compared_with_what_is_true():
    from benchmarks.real.plans import Calibration

    found = Calibration(((0.95, True), (0.93, False), (1.0, True), (0.6, False)))
    assert found.gap == pytest.approx((0.95 + 0.93 + 1 + 0.6 - 2) / 4)
    assert found.steps() == [
        ("0.6 to 0.7", 1, pytest.approx(0.6), 0),
        ("0.9 to 1", 3, pytest.approx(0.96), pytest.approx(2 / 3)),
    ]
    assert Calibration().gap is None and Calibration().steps() == []


def test_a_doorway_without_a_leaf_is_a_door_or_a_passage(tmp_path):
    from benchmarks.real.plans import plan_score
    from benchmarks.real.truth import truth_of

    room = {"name": "main", "polygon": SQUARE, "openings": [door(passage=True)]}
    truth = truth_of(written(tmp_path, rooms=[room]))
    for kind, hits in {"door": 1, "opening": 1, "window": 0}.items():
        score = plan_score([found(openings=[hole(kind=kind)])], truth)
        assert score.openings.typed.hits == hits


def test_polygons_become_fans():
    from benchmarks.real.things import fans

    triangles = fans(np.array([4, 3]), np.array([0, 1, 2, 3, 4, 5, 6]))
    assert triangles.tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6]]


def thing(x=2.0, y=1.5, z=0.0, side=0.5):
    from benchmarks.real.things import PlacedObject

    low, high = np.array([x, y, z]), np.array([x, y, z]) + side
    corners = np.array([[a, b, c] for a in (0, 1) for b in (0, 1) for c in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    points = low + corners * side
    return PlacedObject("chair_1", "chair", (side, side, side), (low + high) / 2, points, faces)


def test_labels_that_say_nothing_may_only_become_boxes(tmp_path):
    from benchmarks.real.things import ThingScore, thing_score
    from benchmarks.real.truth import truth_of

    listed = [
        {"instance": 1, "label": "chair", "center": [2.25, 1.75, 0.25], "size": [0.5] * 3},
        {"instance": 2, "label": "otherprop", "center": [1, 1, 0.2], "size": [0.4] * 3},
        {"instance": 3, "label": "otherprop", "center": [3, 1, 0.2], "size": [0.4] * 3},
    ]
    truth = truth_of(written(tmp_path, objects=[o | {"inside": True} for o in listed]))
    table = {"chair": ["chair", "stool"], "otherprop": None}
    said = {"1": "stool", "2": "clock", "3": "box"}
    score = thing_score(said, {"1": thing()}, truth, table)
    assert score == ThingScore(1, 1, 1, 1, 1, 1, 1, 2, 1)
    assert thing_score({"1": "bed"}, {"1": thing(side=1.0)}, truth, table).category == 0
    assert thing_score({"1": "chair"}, {"1": thing(side=1.0)}, truth, table).size == 0


def test_bodies_outside_in_each_other_and_in_the_air_are_counted(truth):
    pytest.importorskip("fcl")
    from benchmarks.real.bodies import BodyScore, body_score

    square = [np.array(SQUARE, float)]

    def score(*things):
        return body_score(things, square, truth.frame, 2.5)

    assert score(thing()) == BodyScore(1)
    assert score(thing(x=4.0)).outside == 1
    assert score(thing(), thing(x=2.3)).pairs == 1
    assert score(thing(), thing(x=2.501)).pairs == 0
    assert score(thing(z=0.3)).floating == 1
    assert score(thing(z=0.04)).floating == 0
    assert score(thing(), thing(z=0.51)).floating == 0
    assert score(thing(x=3.45, z=0.9)).floating == 0
    assert score(thing(z=1.95)).floating == 0


def test_a_scan_is_written_anew(tmp_path):
    from benchmarks.real.running import ON_ITS_SIDE, variant, write_ply
    from orusd_scans.plainscan import read_scanned

    points = np.random.default_rng(0).uniform(-1, 3, (50, 3))
    columns = {name: points[:, k] for k, name in enumerate("xyz")}
    columns["red"] = columns["green"] = columns["blue"] = np.arange(50, dtype=np.uint8)
    columns["label"] = np.full(50, 5.0)
    faces = np.array([[0, 1, 2], [2, 3, 4]])
    write_ply(tmp_path / "a.ply", columns, faces)
    assert read_scanned(tmp_path / "a.ply").cloud.label is not None
    for change, matrix in {
        "strip": np.eye(3),
        "on its side": ON_ITS_SIDE,
        "millimetres": 1000 * np.eye(3),
    }.items():
        variant(tmp_path / "a.ply", change, tmp_path / "b.ply")
        again = read_scanned(tmp_path / "b.ply")
        assert again.cloud.label is None
        assert again.cloud.colors[:, 0].tolist() == list(range(50))
        assert np.allclose(again.cloud.points, points @ matrix.T)
        assert again.faces.tolist() == faces.tolist()


def test_an_upright_axis_becomes_y():
    from benchmarks.real.running import ON_ITS_SIDE

    assert (ON_ITS_SIDE @ [0, 0, 1]).tolist() == [0, 1, 0]
    assert np.linalg.det(ON_ITS_SIDE) == pytest.approx(1)
