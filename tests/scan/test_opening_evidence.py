"""What looks like an opening and is none, and how likely openings are of which little is seen."""

from dataclasses import replace

import numpy as np
import pytest

from openrooms_usd.scan.openings.cellcounts import CELL_M, faces_of
from openrooms_usd.scan.openings.detection import LIKELY, find_openings
from openrooms_usd.scan.openings.judgement import likelihood
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallholes import Proposal
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.results import FoundOpening
from tests.scan.walled_rooms import (
    CORNERS,
    CURTAIN,
    DOOR,
    HEIGHT,
    WALL,
    WINDOW,
    Sheet,
    casing_of,
    frame_of,
    room,
)

HOLE = Sheet(1, (1.0, 2.0), (1.0, 1.9))
CLOSED = [*casing_of(2, (1.0, 1.9), 2.05, 0.015), Sheet(2, (1.0, 1.9), (0.0, 2.05), 0.0, DOOR)]


def joined(cloud: Cloud, points: np.ndarray) -> Cloud:
    """A cloud with more points, of no label, that face upwards."""
    assert cloud.normals is not None
    up = np.tile(np.array([0, 0, 1], np.float32), (len(points), 1))
    label = None if cloud.label is None else np.append(cloud.label, np.zeros(len(points), np.int32))
    normals = np.concatenate([cloud.normals, up])
    return replace(
        cloud, points=np.concatenate([cloud.points, points]), normals=normals, label=label
    )


def spans(openings: tuple[FoundOpening, ...], wall: int) -> list[list[float]]:
    """Left, right, bottom and top of the openings in a wall."""
    face = faces_of(CORNERS)[wall]
    rings = [face.from_level(o.corners) for o in openings if o.wall == wall]
    return [[*r[:2, 0].tolist(), r[0, 2], r[2, 2]] for r in rings]


def through(cloud: Cloud, moved: np.ndarray) -> np.ndarray:
    """The points that sensors in the room's middle see through the hole, after a motion."""
    seen = cloud.points * moved[:3] + moved[3:]
    origin = np.array([2.0, 1.5, 1.5])
    share = (4.0 - origin[0]) / np.maximum(seen[:, 0] - origin[0], 1e-6)
    _, y, z = (origin + share[:, None] * (seen - origin)).T
    # The right end of the wall is its left one, seen from inside.
    inside = (y > 1.0) & (y < 2.0) & (z > 1.0) & (z < 1.9) & (seen[:, 0] > 4.3)
    return np.asarray(seen[inside])


@pytest.mark.slow
def test_a_mirror_is_no_window() -> None:
    cloud = room([HOLE], labels=False)
    assert len(find_openings(cloud, CORNERS, HEIGHT)) == 1
    reflected = through(cloud, np.array([-1.0, 1, 1, 8, 0, 0]))
    assert len(reflected) > 100
    assert find_openings(joined(cloud, reflected), CORNERS, HEIGHT) == ()
    # Behind a window lies something else: the same points, farther away and shifted.
    others = through(cloud, np.array([-1.0, 1, 1, 8.6, 0.35, 0.3]))
    assert len(others) > 100
    assert len(find_openings(joined(cloud, others), CORNERS, HEIGHT)) == 1


@pytest.mark.parametrize("labels", [True, False])
def test_a_passage_whose_wall_was_not_seen_above_it(labels: bool) -> None:
    cloud = room([Sheet(0, (2.5, 3.4), (0.0, 2.05))], labels=labels)
    low = cloud.take(cloud.points[:, 2] < 2.12)
    (door,) = find_openings(low, CORNERS, HEIGHT)
    assert door.type == "door"
    np.testing.assert_allclose(spans((door,), 0), [[2.5, 3.4, 0.0, 2.08]], atol=0.06)


@pytest.mark.parametrize("labels", [True, False])
@pytest.mark.parametrize(("gap", "count"), [(0.2, 2), (0.06, 1)])
def test_a_pier_parts_windows_and_a_mullion_does_not(labels: bool, gap: float, count: int) -> None:
    panes = [Sheet(1, (x, x + 0.8), (0.9, 2.1)) for x in (0.5, 1.3 + gap)]
    bars = [
        bar
        for x in (0.5, 1.3 + gap)
        for bar in frame_of(1, (x, x + 0.8), (0.9, 2.1), depth=0.08, label=WINDOW)[1:]
    ]
    mullion = Sheet(1, (1.3, 1.3 + gap), (0.9, 2.1), 0.0, WALL if count == 2 else WINDOW)
    found = find_openings(room([*panes, *bars, mullion], labels=labels), CORNERS, HEIGHT)
    assert len(found) == count
    assert all(o.type == "window" for o in found)


def test_a_small_flat_window_has_corners_and_a_blob_of_wrong_labels_none() -> None:
    flat = room([Sheet(1, (1.0, 1.7), (1.0, 1.8), 0.0, WINDOW), *CLOSED])
    assert spans(find_openings(flat, CORNERS, HEIGHT), 1) == [
        pytest.approx([1.0, 1.7, 1.0, 1.8], abs=0.05)
    ]
    assert flat.label is not None
    away = np.linalg.norm(flat.points - [4.0, 1.65, 1.4], axis=1)
    label = np.where(flat.label == WINDOW, WALL, flat.label)
    round_one = replace(flat, label=np.where(away < 0.42, WINDOW, label).astype(np.int32))
    assert spans(find_openings(round_one, CORNERS, HEIGHT), 1) == []


@pytest.mark.slow
def test_the_sides_of_a_hole_are_enough_to_name_it() -> None:
    cloud = room([HOLE, *CLOSED])
    y, z = np.meshgrid([2.0, 1.0], np.arange(1.0, 1.9, 0.01))
    sides = [
        np.column_stack([np.full(y.size, 4.0 + depth), y.ravel(), z.ravel()])
        for depth in np.arange(0.05, 0.2, 0.02)
    ]
    assert spans(find_openings(cloud, CORNERS, HEIGHT), 1) == []
    named = joined(cloud, np.concatenate(sides))
    assert named.label is not None
    assert named.normals is not None
    added = np.arange(len(named)) >= len(cloud)
    normals = np.where(added[:, None], np.array([0, 1, 0], np.float32), named.normals)
    label = np.where(added, WINDOW, named.label).astype(np.int32)
    (window,) = spans(
        find_openings(replace(named, normals=normals, label=label), CORNERS, HEIGHT), 1
    )
    np.testing.assert_allclose(window, [1.0, 2.0, 1.0, 1.9], atol=0.06)


def test_labels_draw_no_hole_beside_them_into_their_window() -> None:
    # Nothing returned beside the window either, from 1.75 m on.
    sheets = [
        *frame_of(0, (0.5, 1.5), (0.9, 2.1), depth=0.08, label=WINDOW),
        Sheet(0, (1.5, 3.7), (0.9, 2.1)),
    ]
    (window, *_) = spans(find_openings(room(sheets), CORNERS, HEIGHT), 0)
    assert window[0] == pytest.approx(0.5, abs=0.05)
    assert window[1] < 2.2


def test_what_hangs_below_a_window_is_its_curtain() -> None:
    window = frame_of(1, (0.8, 2.0), (1.0, 2.1), depth=0.08, label=WINDOW)
    ends = [((0.6, 1.0), (0.3, 0.8)), ((1.8, 2.2), (0.3, 0.8))]
    curtains = [Sheet(1, x, z, -0.1, CURTAIN, cuts=False) for x, z in ends]
    behind = [Sheet(1, x, z) for x, z in ends]
    assert len(find_openings(room([*window, *behind, *curtains]), CORNERS, HEIGHT)) == 1


def test_labels_are_enough_where_their_wall_was_not_seen() -> None:
    window = frame_of(1, (0.8, 2.0), (0.9, 2.1), depth=0.08, label=WINDOW)
    cloud = room([*window, *CLOSED])
    assert cloud.label is not None
    bare = cloud.take(~((cloud.points[:, 0] > 3.9) & (cloud.label == WALL)))
    (found,) = spans(find_openings(bare, CORNERS, HEIGHT), 1)
    np.testing.assert_allclose(found, [0.8, 2.0, 0.9, 2.1], atol=0.06)


def test_a_closed_door_shows_by_its_colour() -> None:
    leaf, picture = Sheet(0, (1.5, 2.4), (0.0, 2.05), 0.0, DOOR), Sheet(2, (1, 2), (1, 2), 0.0, 11)
    cloud = room([leaf, picture])
    assert cloud.label is not None
    random = np.random.default_rng(5)
    shade = np.where(np.isin(cloud.label, (DOOR, 11)), 150.0, 185.0)[:, None]
    colors = np.clip(shade + random.normal(0, 12, (len(cloud), 3)), 0, 255).astype(np.uint8)
    bare = replace(cloud, label=None)
    assert find_openings(bare, CORNERS, HEIGHT) == ()
    (door,) = find_openings(replace(bare, colors=colors), CORNERS, HEIGHT)
    assert door.type == "door"
    np.testing.assert_allclose(spans((door,), 0), [[1.5, 2.4, 0.0, 2.05]], atol=0.05)


def test_doors_have_thresholds_where_floor_lies_behind() -> None:
    sill = Sheet(0, (2.5, 3.4), (0.0, 0.1), 0.0, WALL)
    passage = room([Sheet(0, (2.5, 3.4), (0.0, 2.1)), sill], labels=False)
    (door,) = find_openings(passage, CORNERS, HEIGHT)
    assert (door.type, door.wall) == ("door", 0)
    (french,) = find_openings(passage.take(passage.points[:, 1] > -0.05), CORNERS, HEIGHT)
    assert french.type == "window"


def test_confidence_is_never_certain() -> None:
    window = frame_of(1, (0.8, 2.0), (0.9, 2.1), depth=0.08, label=WINDOW)
    drawn = [
        Sheet(3, (0.8, 2.2), (0.8, 2.3)),
        Sheet(3, (0.7, 2.3), (0.7, 2.4), -0.1, CURTAIN, cuts=False),
    ]
    sure, veiled = find_openings(room([*window, *drawn]), CORNERS, HEIGHT)
    assert sure.confidence == pytest.approx(0.97, abs=0.01)
    # Three of four windows that are guessed behind curtains were there.
    assert veiled.confidence == pytest.approx(0.74)


EVIDENCE = {"hole": 0.95, "framed": 0.9, "walled": 0.95, "headroom": 0.5}
DOORWAY = Proposal("door", Rectangle(0, 82, 40, 74), **EVIDENCE, threshold=1.0)
SHUT = Proposal(
    "door", Rectangle(0, 82, 40, 74), framed=0.9, walled=0.95, solid=1.0, leaf=0.9, headroom=0.5
)
PANE = Proposal("window", Rectangle(36, 88, 40, 90), **EVIDENCE, recess=0.4)


@pytest.mark.parametrize("clear", [DOORWAY, SHUT, PANE])
def test_what_is_clear_is_likely(clear: Proposal) -> None:
    assert likelihood(clear) > 0.75


@pytest.mark.parametrize("clear", [DOORWAY, SHUT, PANE])
@pytest.mark.parametrize("share", ["framed", "walled"])
def test_less_wall_around_is_less_likely(clear: Proposal, share: str) -> None:
    assert likelihood(replace(clear, **{share: 0.2})) < likelihood(clear)


@pytest.mark.parametrize(
    "doubtful",
    [
        # A compartment of a shelf, a niche under the ceiling, a recess before which things stand,
        # a picture behind a desk.
        replace(PANE, where=Rectangle(40, 56, 40, 68), recess=0.95, framed=0.55, clutter=0.5),
        replace(PANE, where=Rectangle(112, 118, 40, 80), recess=0.95, headroom=0.05),
        replace(DOORWAY, hole=0.6, recess=0.5, threshold=0.0, blocked=1.0, framed=0.7),
        replace(SHUT, leaf=0.4, blocked=1.0, clutter=0.3, where=Rectangle(0, 96, 40, 80)),
    ],
)
def test_what_furniture_explains_is_not_built(doubtful: Proposal) -> None:
    assert likelihood(doubtful) < LIKELY


def test_a_view_far_behind_serves_as_well_as_a_threshold() -> None:
    seen = replace(DOORWAY, threshold=0.0, beyond=0.8)
    assert likelihood(seen) == pytest.approx(likelihood(DOORWAY))
    assert likelihood(replace(seen, beyond=0.0)) < likelihood(seen)


def test_cells_are_of_the_size_that_these_rectangles_assume() -> None:
    assert pytest.approx(0.025) == CELL_M
