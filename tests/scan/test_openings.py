"""Doors and windows of rooms whose openings are known."""

from dataclasses import replace

import numpy as np
import pytest

from openrooms_usd.scan.openings.cellcounts import CELL_M, faces_of
from openrooms_usd.scan.openings.detection import LIKELY, behind_curtain, find_openings
from openrooms_usd.scan.openings.judgement import without_casing
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallpicture import wall_grids
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.sightlines import sight_of
from openrooms_usd.scan.results import FoundOpening
from tests.scan.walled_rooms import (
    CORNERS,
    CURTAIN,
    DOOR,
    HEIGHT,
    SENSOR_ORIGINS,
    WINDOW,
    Sheet,
    casing_of,
    frame_of,
    room,
)

WINDOWED = frame_of(1, (0.8, 2.0), (0.9, 2.1), depth=0.08, label=WINDOW)
PASSAGE = [Sheet(0, (2.5, 3.4), (0.0, 2.1))]
CLOSED = [*casing_of(2, (1.0, 1.9), 2.05, 0.015), Sheet(2, (1.0, 1.9), (0.0, 2.05), 0.0, DOOR)]


def in_wall(opening: FoundOpening, corners: np.ndarray = CORNERS) -> np.ndarray:
    """(4, 3) an opening's corners in the frame of its wall."""
    return faces_of(corners)[opening.wall].from_level(opening.corners)


def assert_found(
    opening: FoundOpening,
    kind: str,
    wall: int,
    x: tuple[float, float],
    z: tuple[float, float],
    within: float = 0.05,
) -> None:
    assert (opening.type, opening.wall) == (kind, wall)
    expected = [(x[0], 0, z[0]), (x[1], 0, z[0]), (x[1], 0, z[1]), (x[0], 0, z[1])]
    np.testing.assert_allclose(in_wall(opening), expected, atol=within)


@pytest.mark.parametrize("labels", [True, False])
def test_window_passage_and_closed_door(labels: bool) -> None:
    found = find_openings(room([*WINDOWED, *PASSAGE, *CLOSED], labels=labels), CORNERS, HEIGHT)
    assert len(found) == 3
    passage, window, door = found
    assert_found(passage, "door", 0, (2.5, 3.4), (0.0, 2.1))
    assert_found(window, "window", 1, (0.8, 2.0), (0.9, 2.1))
    assert_found(door, "door", 2, (1.0, 1.9), (0.0, 2.05))
    assert all(0.4 <= opening.confidence <= 1.0 for opening in found)


def test_walls_without_openings_have_none() -> None:
    for labels in (True, False):
        assert find_openings(room(labels=labels), CORNERS, HEIGHT) == ()


def test_corners_run_counter_clockwise_from_the_bottom_left_seen_from_inside() -> None:
    found = find_openings(room([*WINDOWED, *PASSAGE]), CORNERS, HEIGHT)
    assert len(found) == 2
    for opening in found:
        a, b, _, d = opening.corners
        out = np.cross(b - a, d - a)
        assert out @ (np.array([2.0, 1.5, 1.3]) - a) > 0
        assert d[2] > a[2] == b[2]


def test_wardrobe_before_a_wall_is_no_hole() -> None:
    hidden = [
        Sheet(0, (1.0, 2.2), (0.0, 2.0)),
        Sheet(0, (1.0, 2.2), (0.0, 2.0), -0.6, 3, cuts=False),
    ]
    # Without a floor below it: nobody sees that through a wardrobe.
    cloud = room(hidden, labels=False)
    assert find_openings(cloud.take(cloud.points[:, 1] > -0.05), CORNERS, HEIGHT) == ()


def test_returns_six_centimetres_apart_suffice() -> None:
    cloud = room([*WINDOWED, *PASSAGE], labels=False)
    _, rows = np.unique(np.round(cloud.points / 0.06), axis=0, return_index=True)
    found = find_openings(cloud.take(np.sort(rows)), CORNERS, HEIGHT)
    assert sorted(opening.type for opening in found) == ["door", "window"]


def test_what_is_doubtful_is_told_apart_and_displaces_nothing() -> None:
    cloud = room([*WINDOWED, *PASSAGE, *CLOSED], labels=False)
    sure = find_openings(cloud, CORNERS, HEIGHT)
    whole = find_openings(cloud, CORNERS, HEIGHT, 0.01)
    kept = [opening for opening in whole if opening.confidence >= LIKELY]
    assert len(kept) == len(sure) > 0
    assert all(np.array_equal(a.corners, b.corners) for a, b in zip(kept, sure, strict=True))


def test_wrong_labels_on_a_flat_wall_are_no_window() -> None:
    cloud = room(WINDOWED)
    assert cloud.label is not None
    away = np.linalg.norm(cloud.points - [2.0, 0.0, 1.2], axis=1)
    label = np.where(away < 0.25, WINDOW, cloud.label).astype(np.int32)
    (window,) = find_openings(replace(cloud, label=label), CORNERS, HEIGHT)
    assert window.wall == 1


@pytest.mark.slow
def test_a_fifth_of_the_labels_wrong() -> None:
    cloud = room([*WINDOWED, *PASSAGE, *CLOSED])
    assert cloud.label is not None
    random, label = np.random.default_rng(3), cloud.label.copy()
    wrong = np.zeros(len(label), dtype=bool)
    while wrong.mean() < 0.2:
        middle, other = random.integers(len(label), size=2)
        near = np.linalg.norm(cloud.points - cloud.points[middle], axis=1) < 0.15
        wrong |= near
        label[near] = cloud.label[other]
    found = find_openings(replace(cloud, label=label), CORNERS, HEIGHT)
    assert [(o.type, o.wall) for o in found] == [("door", 0), ("window", 1), ("door", 2)]


def test_window_behind_a_curtain_needs_its_label() -> None:
    drawn = [
        Sheet(1, (0.8, 2.2), (0.8, 2.3)),
        Sheet(1, (0.68, 2.32), (0.7, 2.4), -0.1, CURTAIN, cuts=False),
    ]
    # Some other opening has a label, so that labels are known to mean openings.
    cloud = room([*drawn, *CLOSED])
    window = next(o for o in find_openings(cloud, CORNERS, HEIGHT) if o.wall == 1)
    assert_found(window, "window", 1, (0.8, 2.2), (0.8, 2.3), within=0.11)
    assert window.confidence < 0.8
    bare = find_openings(replace(cloud, label=None), CORNERS, HEIGHT)
    assert all(o.wall != 1 for o in bare)


def test_curtains_are_larger_than_their_windows() -> None:
    assert behind_curtain(Rectangle(20, 80, 30, 90)) == Rectangle(24, 76, 35, 85)
    # What is hardly larger than that is left as it is.
    assert behind_curtain(Rectangle(20, 30, 30, 42)) == Rectangle(20, 30, 30, 42)
    # However low one hangs, something is behind it.
    low = [behind_curtain(Rectangle(0, top, 30, 90)) for top in range(1, 80)]
    assert all(0 <= where.bottom < where.top for where in low)


def test_french_window_ends_above_a_low_sill() -> None:
    low = frame_of(1, (0.8, 2.0), (0.12, 2.2), depth=0.08, label=WINDOW)
    (window,) = find_openings(room(low, labels=False), CORNERS, HEIGHT)
    assert_found(window, "window", 1, (0.8, 2.0), (0.12, 2.2))


def test_boards_around_a_door_are_not_the_door() -> None:
    cloud = room([*casing_of(2, (1.0, 1.9), 2.05, 0.015), Sheet(2, (1.0, 1.9), (0.0, 2.05))])
    sight = sight_of(cloud.points, SENSOR_ORIGINS)
    grid = list(wall_grids(cloud, CORNERS, HEIGHT, sight))[2]
    outside = Rectangle(0, round(2.12 / CELL_M), round(0.925 / CELL_M), round(1.975 / CELL_M))
    trimmed = without_casing(grid, outside)
    edges = CELL_M * np.array([trimmed.left, trimmed.right, trimmed.top])
    np.testing.assert_allclose(edges, [1.0, 1.9, 2.05], atol=CELL_M)
    # A board that is named a door, and nothing else.
    board = replace(outside, right=outside.left + 2)
    assert without_casing(grid, board) == board


@pytest.mark.slow
def test_two_windows_stay_two() -> None:
    pair = [
        *frame_of(0, (0.5, 1.5), (0.9, 2.1), depth=0.08, label=WINDOW),
        *frame_of(0, (1.8, 2.8), (0.9, 2.1), depth=0.08, label=WINDOW),
    ]
    for labels in (True, False):
        assert len(find_openings(room(pair, labels=labels), CORNERS, HEIGHT)) == 2


def test_openings_keep_away_from_the_corners() -> None:
    wide = frame_of(1, (0.0, 3.0), (0.9, 2.1), depth=0.08, label=WINDOW)
    (window,) = find_openings(room(wide), CORNERS, HEIGHT)
    x = in_wall(window)[:, 0]
    assert x.min() == pytest.approx(0.05)
    assert x.max() == pytest.approx(2.95)


@pytest.mark.slow
def test_what_turns_with_the_room_is_found_in_it() -> None:
    cloud, angle = room([*WINDOWED, *PASSAGE], labels=False), np.radians(33.0)
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    matrix[:2, 3] = 5.0, -2.0
    corners = CORNERS @ matrix[:2, :2].T + matrix[:2, 3]
    plain = find_openings(cloud, CORNERS, HEIGHT)
    turned = find_openings(cloud.moved(matrix), corners, HEIGHT)
    assert [o.type for o in plain] == [o.type for o in turned] == ["door", "window"]
    for a, b in zip(plain, turned, strict=True):
        np.testing.assert_allclose(in_wall(a), in_wall(b, corners), atol=0.03)


@pytest.mark.slow
def test_the_same_scan_gives_the_same_bits() -> None:
    cloud = room([*WINDOWED, *PASSAGE])
    first, second = (find_openings(cloud, CORNERS, HEIGHT) for _ in range(2))
    for a, b in zip(first, second, strict=True):
        assert a.corners.tobytes() == b.corners.tobytes()
        assert a.confidence == b.confidence


@pytest.mark.parametrize("count", [0, 1, 30])
def test_hardly_any_points(count: int) -> None:
    cloud = room(labels=False).take(np.arange(count))
    assert find_openings(cloud, CORNERS, HEIGHT) == ()
    assert find_openings(Cloud(cloud.points), CORNERS, None) == ()


def test_walls_that_were_not_seen_show_no_holes() -> None:
    assert find_openings(room(labels=False, missing=[3]), CORNERS, HEIGHT) == ()
