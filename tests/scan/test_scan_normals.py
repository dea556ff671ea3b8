"""Normals of points on known surfaces, and to which side they look."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.normals import estimate_normals, towards, views, with_normals


def sphere(count: int, offset: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True) + offset


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_a_sphere_seen_from_its_middle(offset: float) -> None:
    points = sphere(20_000, offset)
    cloud = with_normals(Cloud(points, sensor_origins=np.full((1, 3), offset)))
    cosines = -np.einsum("ni,ni->n", cloud.normals, points - offset)
    assert np.degrees(np.arccos(cosines.clip(-1, 1))).mean() < 1.0
    assert cosines.min() > 0.97


def test_the_two_sides_of_a_wall_look_to_their_own_eyes() -> None:
    rng = np.random.default_rng(1)
    sheet = rng.uniform(0, 1, (4000, 3)) * [2.0, 0.0, 2.0]
    points = np.concatenate([sheet[:2000], sheet[2000:] + np.array([0.0, 0.3, 0.0])])
    sensor_origins = np.array([[1.0, -1.0, 1.0], [1.0, 1.3, 1.0]])
    normals = with_normals(Cloud(points, sensor_origins=sensor_origins)).normals
    assert (normals[:2000, 1] < -0.99).all()
    assert (normals[2000:, 1] > 0.99).all()


def test_without_eyes_walls_look_inwards() -> None:
    points = sphere(3000, 5.0)
    cloud = with_normals(Cloud(points))
    assert (np.einsum("ni,ni->n", cloud.normals, points - 5.0) < 0.0).all()


def test_given_normals_stay() -> None:
    given = np.tile(np.array([[0, 0, 1]], "f4"), (5, 1))
    cloud = Cloud(np.random.default_rng(2).random((5, 3)), normals=given)
    assert with_normals(cloud) is cloud


def test_few_points() -> None:
    for count in range(4):
        normals = estimate_normals(np.random.default_rng(3).random((count, 3)))
        assert normals.shape == (count, 3)
        assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(count))
    assert (estimate_normals(np.zeros((20, 3))) ** 2).sum(axis=1) == pytest.approx(np.ones(20))
    assert views(np.empty((0, 3)), None).shape == (0, 3)


def test_turning_keeps_what_looks_the_right_way() -> None:
    normals = np.array([[0, 0, 1], [0, 0, 1]], "f4")
    turned = towards(normals, np.array([[0.1, 0, 1.0], [0, 5.0, -0.1]]))
    assert turned.tolist() == [[0, 0, 1], [0, 0, -1]]
