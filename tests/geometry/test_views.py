"""View selection: hand-computed scores, and scenes in which the right answer is known."""

import numpy as np
import pytest
import shapely

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.looks import NOTHING, Sights, Views, parts_of, sights_of, visible
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import is_rotation
from openrooms_usd.geometry.views import (
    CLEARANCE,
    PITCH,
    YAW,
    clear,
    differing,
    rate_views,
    sample_views,
    score,
    select_views,
    sphere_directions,
)

SQUARE = np.array([[0.0, 0], [5, 0], [5, 4], [0, 4]])
QUADS = np.array(
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
)


def cuboids(*boxes: tuple[tuple[float, ...], tuple[float, ...], bool]) -> tuple[Array, Array]:
    """Boxes given by two corners and whether they are seen from within."""
    unit = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    points, triangles = [], []
    for number, (low, high, inward) in enumerate(boxes):
        points.append(np.array(low) + unit * (np.array(high) - np.array(low)))
        quads = QUADS[:, ::-1] if inward else QUADS
        triangles.append(8 * number + np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
    return np.concatenate(points), np.concatenate(triangles)


ROOM = ((0.0, 0, 0), (5.0, 4, 2.6), True)
TABLE = ((2.0, 1.5, 0.7), (3.2, 2.5, 0.75), False)
FURNISHED = [
    (
        (4.0 + 0.2 * (k % 4), 3.0 + 0.2 * (k // 4), 0.0),
        (4.12 + 0.2 * (k % 4), 3.12 + 0.2 * (k // 4), 0.4 + 0.1 * (k % 3)),
        False,
    )
    for k in range(16)
]


# --- score ---


def test_a_flat_wall_scores_by_its_depth_alone() -> None:
    normals = np.tile([0.0, 1.0, 0.0], (3, 4, 1))
    assert score(normals, np.full((3, 4), np.e - 1)) == pytest.approx(0.3 * 12)


def test_each_edge_between_pixels_counts_in_all_channels_and_both_directions() -> None:
    normals = np.zeros((2, 3, 3))
    normals[:, :2] = [1, 0, 0]
    normals[:, 2] = [0, 1, 0]
    # Across: one edge in each of two rows, two channels change by 1. Down: nothing changes.
    assert score(normals, np.zeros((2, 3))) == pytest.approx(4.0)
    normals[1] = [0, 0, -1]
    # Across: one edge in the first row. Down: three pixels, two channels each.
    assert score(normals, np.zeros((2, 3))) == pytest.approx(2.0 + 6.0)


def test_many_views_are_scored_as_one_by_one() -> None:
    rng = np.random.default_rng(0)
    normals, depth = rng.normal(size=(5, 6, 7, 3)), rng.random((5, 6, 7))
    np.testing.assert_allclose(
        score(normals, depth), [score(n, d) for n, d in zip(normals, depth, strict=True)]
    )


# --- sampling ---


@pytest.mark.parametrize(
    "polygon",
    [
        SQUARE,
        SQUARE[::-1],
        np.array([[0.0, 0], [6, 0], [6, 3], [3, 3], [3, 6], [0, 6]]),
        np.array([[0.0, 0], [9, 0], [9, 0.9], [0, 0.9]]),  # most of the range is outside
    ],
)
def test_eyes_stand_along_the_walls_at_their_height_and_face_the_centre(polygon: Array) -> None:
    views = sample_views(polygon, 0.5, 400, np.random.default_rng(1))
    assert len(views) > 100
    shape = shapely.Polygon(polygon)
    assert shapely.contains_xy(shape, views.eyes[:, 0], views.eyes[:, 1]).all()
    assert views.eyes[:, 2].min() >= 0.5 + 1.4
    assert views.eyes[:, 2].max() <= 0.5 + 1.8
    to_wall = shapely.distance(shape.exterior, shapely.points(views.eyes[:, :2]))
    assert to_wall.max() <= 1.5 + 1e-9
    rise = np.degrees(np.arcsin(views.forwards[:, 2]))
    assert rise.min() >= PITCH[0]
    assert rise.max() <= PITCH[1]
    np.testing.assert_allclose(np.linalg.norm(views.forwards, axis=1), 1.0)
    if polygon.max() == 5:
        to_centre = np.array([2.5, 2.0]) - views.eyes[:, :2]
        turn = np.arctan2(
            np.cross(np.c_[to_centre, np.zeros(len(views))], views.forwards)[:, 2],
            (to_centre * views.forwards[:, :2]).sum(axis=1),
        )
        assert np.abs(np.degrees(turn)).max() <= YAW + 1e-9
        assert np.abs(np.degrees(turn)).max() > 0.9 * YAW
    assert all(is_rotation(pose[:3, :3], 1e-9) for pose in views.poses())


def test_the_generator_decides_alone() -> None:
    first, again, other = (
        sample_views(SQUARE, 0.0, 50, np.random.default_rng(seed)) for seed in (3, 3, 4)
    )
    np.testing.assert_array_equal(first.eyes, again.eyes)
    np.testing.assert_array_equal(first.forwards, again.forwards)
    assert not np.array_equal(first.eyes[0], other.eyes[0])


def test_a_point_is_no_room() -> None:
    with pytest.raises(InputError, match="no sides"):
        sample_views(np.ones((3, 2)), 0.0, 5, np.random.default_rng(0))


# --- rejecting ---


def test_eyes_in_or_near_furniture_are_no_eyes() -> None:
    solid = ((1.0, 1, 0), (2.0, 2, 2.0), False)
    caster = RayCaster(*cuboids(ROOM, solid))
    eyes = np.array(
        [
            [1.5, 1.5, 1.5],  # inside the solid, 0.5 m from its faces
            [2.1, 1.5, 1.5],  # 10 cm from it
            [2.5, 1.5, 1.5],  # free
            [4.9, 2.0, 1.5],  # 10 cm from a wall
            [4.5, 3.5, 2.0],  # free
        ]
    )
    np.testing.assert_array_equal(clear(caster, eyes), [False, False, True, False, True])
    assert clear(caster, np.array([[2.0 + 1.05 * CLEARANCE, 1.5, 1.5]])).all()


def test_directions_cover_the_sphere_evenly() -> None:
    directions = sphere_directions(500)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    np.testing.assert_allclose(directions.mean(axis=0), 0.0, atol=0.01)
    np.testing.assert_allclose(directions.T @ directions / 500, np.eye(3) / 3, atol=0.01)


def test_blocked_and_empty_views_are_out_of_the_question() -> None:
    caster = RayCaster(*cuboids(ROOM, ((2.3, 1.0, 1.0), (2.4, 3.0, 2.0), False)))
    eyes = np.array([[2.0, 2, 1.5], [1.0, 2, 1.5], [9.0, 2, 1.5]])
    forwards = np.array([[1.0, 0, 0], [1, 0, 0], [1, 0, 0]])
    rated = rate_views(caster, Views(eyes, forwards), 60.0, (40, 30))
    np.testing.assert_array_equal(np.isfinite(rated), [False, True, False])


def test_the_rating_of_a_wall_is_its_closed_form() -> None:
    """A square picture of a facing wall at 2 m: no edges, planar depth the same everywhere."""
    caster = RayCaster(
        [[-50.0, 2, -50], [50, 2, -50], [50, 2, 50], [-50, 2, 50]], [[0, 1, 2], [0, 2, 3]]
    )
    rated = rate_views(caster, Views(np.zeros((1, 3)), np.array([[0.0, 1, 0]])), 90.0, (24, 24))
    assert rated[0] == pytest.approx(0.3 * 24 * 24 * np.log(3.0))


def test_the_winding_of_a_wall_does_not_change_the_rating() -> None:
    points, triangles = cuboids(ROOM, TABLE)
    views = sample_views(SQUARE, 0.0, 40, np.random.default_rng(5))
    rng = np.random.default_rng(6)
    mixed = triangles.copy()
    flip = rng.random(len(mixed)) < 0.5
    mixed[flip] = mixed[flip][:, ::-1]
    np.testing.assert_allclose(
        rate_views(RayCaster(points, mixed), views, 60.0, (40, 30)),
        rate_views(RayCaster(points, triangles), views, 60.0, (40, 30)),
    )


# --- choosing ---


def test_the_best_that_differ_are_taken_in_their_order() -> None:
    eyes = np.array([[0.0, 0, 1.5], [0.1, 0, 1.5], [3, 0, 1.5], [0, 0, 1.5], [6, 0, 1.5]])
    forwards = np.array([[1.0, 0, 0]] * 3 + [[0.0, 1, 0], [1, 0, 0]])
    scores = np.array([10.0, 9.0, 8.0, 7.0, -np.inf])
    views = Views(eyes, forwards)
    # 1 is 10 cm beside 0; 3 looks 90 degrees away from it.
    assert differing(views, scores, 3).tolist() == [0, 2, 3]
    assert differing(views, scores, 4).tolist() == [0, 1, 2, 3]  # then the near one after all
    assert differing(views, scores, 9).tolist() == [0, 1, 2, 3]  # but never the impossible
    assert differing(views, np.full(5, -np.inf), 3).tolist() == []


def test_a_furnished_corner_wins_over_bare_walls() -> None:
    """All furniture stands in one corner: the best view must show it."""
    caster = RayCaster(*cuboids(ROOM, *FURNISHED))
    candidates = sample_views(SQUARE, 0.0, 200, np.random.default_rng(7))
    best = select_views(caster, candidates, 1, fov_degrees=60.0)
    towards = np.array([4.35, 3.35, 0.3]) - best.eyes[0]
    towards /= np.linalg.norm(towards)
    assert np.degrees(np.arccos(towards @ best.forwards[0])) < 30.0


@pytest.mark.slow
def test_selection_gives_as_many_as_asked_and_always_the_same() -> None:
    caster = RayCaster(*cuboids(ROOM, TABLE))
    candidates = sample_views(SQUARE, 0.0, 150, np.random.default_rng(8))
    first, again = (select_views(caster, candidates, 5, fov_degrees=60.0) for _ in range(2))
    assert len(first) == 5
    np.testing.assert_array_equal(first.eyes, again.eyes)
    assert clear(caster, first.eyes).all()
    assert not len(select_views(caster, candidates[:0], 5, fov_degrees=60.0))


def test_several_views_show_the_room_and_its_openings() -> None:
    """All furniture stands in one corner: the first view shows it, the others what is elsewhere."""
    caster = RayCaster(*cuboids(ROOM, *FURNISHED))
    candidates = sample_views(SQUARE, 0.0, 200, np.random.default_rng(7))
    doors = np.array([[0.05, 1.0, 1.0], [1.0, 0.05, 1.0], [4.95, 1.0, 1.5]])
    best = select_views(caster, candidates, 3, fov_degrees=60.0, places=doors)
    seen = visible(caster, best.eyes, best.forwards, doors, fov_degrees=60.0, aspect=4 / 3)
    assert seen.any(axis=0).all()
    assert not seen[0].all()
    cosines = best.forwards[:, :2] @ best.forwards[:, :2].T
    level = np.linalg.norm(best.forwards[:, :2], axis=1)
    turned = np.degrees(np.arccos(np.clip(cosines / np.outer(level, level), -1, 1)))
    assert turned.max() > 60.0


def test_what_is_seen_is_in_the_picture_and_not_behind_a_thing() -> None:
    caster = RayCaster(*cuboids(ROOM, ((2.3, 1.0, 0.0), (2.4, 3.0, 2.6), False)))
    eye, ahead = np.array([[1.0, 2, 1.5]]), np.array([[1.0, 0, 0]])
    places = np.array(
        [
            [2.2, 2.0, 1.5],  # before the wall in the middle
            [2.28, 2.0, 1.5],  # at it
            [4.9, 2.0, 1.5],  # behind it
            [2.0, 3.9, 1.5],  # beside the picture
            [0.1, 2.0, 1.5],  # behind the camera
        ]
    )
    seen = visible(caster, eye, ahead, places, fov_degrees=60.0, aspect=4 / 3)
    assert seen.tolist() == [[True, True, False, False, False]]
    assert visible(caster, eye, ahead, places[:0], fov_degrees=60.0, aspect=1.0).shape == (1, 0)


def test_news_are_the_share_of_parts_and_of_places_that_nobody_else_shows() -> None:
    points = np.array(
        [
            [[0.1, 0.1, 0.1], [0.2, 0.4, 0.3]],
            [[0.1, 0.1, 0.1], [0.7, 0.1, 0.1]],
            [[3.0, 3.0, 1.0], [-0.1, 0.0, 0.0]],
        ]
    )
    parts = parts_of(points, np.array([[True, True], [True, True], [True, False]]))
    assert parts[0, 0] == parts[0, 1] == parts[1, 0] != parts[1, 1]
    assert parts[2, 1] == NOTHING
    sights = sights_of(parts, np.array([[True, False], [True, False], [False, True]]))
    assert sights.parts.sum(axis=1).tolist() == [1, 2, 1]
    none = np.zeros(0, dtype=np.int64)
    assert sights.news(none) == pytest.approx([1 / 3 + 1 / 2, 2 / 3 + 1 / 2, 1 / 3 + 1 / 2])
    assert sights.news(np.array([0])) == pytest.approx([0.0, 1 / 3, 1 / 3 + 1 / 2])


def test_what_shows_something_new_comes_before_what_is_a_little_better() -> None:
    """Four views apart from each other; the second best shows what the best shows."""
    eyes = np.array([[0.0, 0, 1.5], [3, 0, 1.5], [6, 0, 1.5], [9, 0, 1.5]])
    views = Views(eyes, np.tile([1.0, 0, 0], (4, 1)))
    scores = np.array([10.0, 9.0, 8.0, 1.0])
    parts = np.array([[1, 1, 0, 0], [1, 1, 0, 0], [1, 0, 1, 0], [0, 0, 0, 1]], dtype=bool)
    sights = Sights(parts, np.zeros((4, 0), dtype=bool))
    assert differing(views, scores, 2).tolist() == [0, 1]
    assert differing(views, scores, 2, sights).tolist() == [0, 2]
    assert differing(views, scores, 3, sights).tolist() == [0, 2, 3]
    assert differing(views, scores, 4, sights).tolist() == [0, 1, 2, 3]
