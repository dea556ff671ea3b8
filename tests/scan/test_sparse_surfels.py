"""Surfels of sparse scans: both faces of a thin wall are told apart, stray points are none."""

import numpy as np

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.nearest import nearest_planes
from openrooms_usd.scan.points.surfels import surfels

SPACING, THICKNESS = 0.13, 0.18


def grid(rng: np.random.Generator, spacing: float = SPACING) -> np.ndarray:
    """(N, 2) jittered points of 3 x 3 m."""
    steps = np.arange(0.0, 3.0, spacing)
    plan = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return plan + spacing * rng.uniform(-0.2, 0.2, plan.shape)


def two_faces() -> np.ndarray:
    rng = np.random.default_rng(3)
    faces = [
        np.column_stack([place, np.full(len(place), x)])
        for x in (0.0, THICKNESS)
        for place in (grid(rng),)
    ]
    return np.concatenate(faces) + 0.003 * rng.normal(size=(2 * len(faces[0]), 3))


def test_both_faces_of_a_thin_wall_have_surfels():
    pieces = surfels(Cloud(two_faces()))
    upright = np.abs(pieces.normals[:, 2]) > np.cos(np.deg2rad(10.0))
    assert upright.mean() > 0.95
    for height in (0.0, THICKNESS):
        near = upright & (np.abs(pieces.points[:, 2] - height) < 0.02)
        # At the spacing of dense scans: 9 m2 in cells of 5 cm.
        assert near.sum() > 0.5 * 9.0 / 0.05**2


def test_a_place_at_an_edge_lies_on_one_of_its_faces():
    rng = np.random.default_rng(4)
    place = grid(rng)
    floor = np.column_stack([place, np.zeros(len(place))])
    wall = np.column_stack([place[:, 0], np.full(len(place), -0.06), place[:, 1] + 0.06])
    points = np.concatenate([floor, wall])
    found = nearest_planes(points, points)
    inner = (np.abs(points[:, 0] - 1.5) < 1.2) & (points[:, 1:] < 2.7).all(axis=1)
    along = np.abs(found.normals[:, 1:]).max(axis=1)
    assert (along[inner] > np.cos(np.deg2rad(10.0))).mean() > 0.97


def test_stray_points_are_no_surfaces():
    points = np.random.default_rng(5).uniform(-1.0, 1.0, (4000, 3))
    assert nearest_planes(points, points).flat.mean() < 0.15
    assert nearest_planes(two_faces(), two_faces()).flat.mean() > 0.9


def test_too_few_points_give_no_plane():
    points = np.zeros((3, 3)) + np.eye(3)
    assert not nearest_planes(points, points).flat.any()
