"""Views as photographs: where people stand, and scenes whose best picture is known."""

import numpy as np
import pytest
import shapely

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.composition import BARE, NO_SUBJECT, Subjects, photographic_rating
from openrooms_usd.geometry.looks import Views, rated
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.viewpoints import PITCH_DEG, photographers_views
from tests.geometry.test_views import ROOM, SQUARE, cuboids

L_SHAPE = np.array([[0.0, 0], [6, 0], [6, 3], [3, 3], [3, 6], [0, 6]])
# A sofa, 2 m wide.
SOFA = ((1.0, 3.0, 0.0), (3.0, 3.9, 0.8), False)


def ratings(
    eyes: Array, aims: Array, *more: tuple[tuple[float, ...], tuple[float, ...], bool]
) -> Array:
    """Of views of a room with a sofa as its only subject, and other things."""
    points, triangles = cuboids(ROOM, SOFA, *more)
    caster = RayCaster(points, triangles)
    subject = np.full(len(triangles), NO_SUBJECT, dtype=np.int32)
    subject[:12], subject[12:24] = BARE, 0
    subjects = Subjects(points[triangles[12:24]].mean(axis=1)[None], np.array([4.0]), subject)
    forwards = aims - eyes
    views = Views(eyes, forwards / np.linalg.norm(forwards, axis=1, keepdims=True))
    rating = photographic_rating(caster, subjects, floor=0.0, diagonal=6.4)
    return rated(caster, views, 65.0, (40, 30), rating)[0]


@pytest.mark.parametrize("outline", [SQUARE, SQUARE[::-1], L_SHAPE])
def test_people_stand_inside_level_and_often_in_corners_and_doorways(outline: Array) -> None:
    door = np.array([[1.0, 0.05, 1.0]])
    views = photographers_views(outline, 0.5, 400, np.random.default_rng(1), doorways=door)
    assert len(views) > 250
    shape = shapely.Polygon(outline)
    assert shapely.contains_xy(shape, views.eyes[:, 0], views.eyes[:, 1]).all()
    assert views.eyes[:, 2].min() >= 1.7
    assert views.eyes[:, 2].max() <= 2.1
    rise = np.degrees(np.arcsin(views.forwards[:, 2]))
    assert PITCH_DEG[0] <= rise.min() < rise.max() <= PITCH_DEG[1] <= 0.0
    away = np.linalg.norm(views.eyes[:, None, :2] - outline, axis=2).min(axis=1)
    assert (away < 0.8 * np.sqrt(2.0)).mean() > 0.3
    assert (np.linalg.norm(views.eyes[:, :2] - door[0, :2], axis=1) < 0.85).mean() > 0.1


def test_a_wall_that_is_nearly_faced_is_faced_squarely() -> None:
    views = photographers_views(
        SQUARE, 0.0, 400, np.random.default_rng(2), doorways=np.zeros((0, 3))
    )
    yaw = np.degrees(np.arctan2(views.forwards[:, 1], views.forwards[:, 0]))
    off = np.abs((yaw + 45.0) % 90.0 - 45.0)
    square = off < 1e-6
    assert 0.1 < square.mean() < 0.6
    assert off[~square].min() >= 12.0


def test_the_subject_is_whole_and_nothing_is_before_it() -> None:
    eye, whole, cut = [2.0, 0.4, 1.4], [2.0, 3.4, 1.1], [4.0, 3.4, 1.1]
    best, half = ratings(np.array([eye, eye]), np.array([whole, cut]))
    assert half < 0.5 * best
    post = ((1.75, 1.9, 0.0), (2.25, 2.1, 2.0), False)
    assert ratings(np.array([eye]), np.array([whole]), post)[0] < 0.9 * best
    hidden = ((0.9, 2.0, 0.0), (3.1, 2.2, 2.0), False)
    assert ratings(np.array([eye]), np.array([whole]), hidden)[0] < 0.3 * best


def test_what_is_right_before_the_lens_costs_most_of_the_score() -> None:
    eye, aim = np.array([[2.0, 0.4, 1.4]]), np.array([[2.0, 3.4, 1.1]])
    lamp = ((1.72, 0.85, 1.15), (1.85, 0.95, 1.6), False)
    assert ratings(eye, aim, lamp)[0] < 0.5 * ratings(eye, aim)[0]


def test_a_shelf_beside_the_lens_costs_half_of_the_score() -> None:
    eye, aim = np.array([[2.0, 0.4, 1.4]]), np.array([[2.0, 3.4, 1.1]])
    shelf = ((1.0, 0.9, 0.0), (1.35, 1.8, 2.2), False)
    assert ratings(eye, aim, shelf)[0] < 0.5 * ratings(eye, aim)[0]
    table = ((0.9, 0.9, 0.0), (1.5, 1.5, 0.7), False)
    assert ratings(eye, aim, table)[0] > 0.8 * ratings(eye, aim)[0]


@pytest.mark.parametrize(("away", "near"), [(0.8, True), (1.1, False)])
def test_a_thing_before_the_lens_costs_by_its_share_of_the_picture(away: float, near: bool) -> None:
    """A plate across the line of sight, low in the picture, against the same view without it."""
    eye, aim, wide = np.array([[3.0, 0.3, 1.4]]), np.array([[3.0, 4.0, 1.4]]), 0.12
    half = np.tan(np.radians(0.5 * 65.0)) * away
    low = 1.4 - 0.9 * 0.75 * half
    corners = (3.0 - wide, 0.3 + away, low), (3.0 + wide, 0.305 + away, low + wide)
    plate = (*corners, False)
    bare, before = ratings(eye, aim)[0], ratings(eye, aim, plate)[0]
    share = 2.0 * wide * wide / (4.0 * half * half * 0.75)
    assert -np.log(before / bare) == pytest.approx(
        share / 0.25 + near * share / 0.03, rel=0.4, abs=0.3
    )


def test_half_of_the_views_aim_at_a_subject() -> None:
    subject = np.array([[4.5, 0.5, 0.4]])
    views = photographers_views(
        SQUARE, 0.0, 400, np.random.default_rng(3), doorways=np.zeros((0, 3)), subjects=subject
    )
    x, y = (subject[0, :2] - views.eyes[:, :2]).T
    off = np.angle(np.exp(1j * (np.arctan2(y, x) - np.arctan2(*views.forwards.T[1::-1]))))
    # Give or take their spread, and the turn towards a wall that is nearly faced.
    assert (np.abs(np.degrees(off)) < 15.0 + 12.0).mean() > 0.5


def test_steep_looks_at_the_floor_and_bare_walls_come_last() -> None:
    eyes = np.array([[2.0, 0.4, 1.4], [2.0, 0.9, 1.4], [4.0, 2.0, 1.4]])
    aims = np.array([[2.0, 3.4, 1.1], [2.0, 1.9, 0.0], [4.9, 2.0, 1.4]])
    level, steep, wall = ratings(eyes, aims)
    assert steep < 0.3 * level
    assert wall < 0.1 * level


def test_nobody_photographs_from_above_a_cupboard() -> None:
    eye, aim = np.array([[2.0, 0.4, 1.4]]), np.array([[2.0, 3.4, 1.1]])
    cupboard = ((1.6, 0.05, 0.0), (2.4, 0.5, 0.8), False)
    assert ratings(eye, aim, cupboard)[0] == pytest.approx(0.4 * ratings(eye, aim)[0])
