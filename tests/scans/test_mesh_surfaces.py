"""Meshes as clouds: even samples on large triangles, few on small ones, all from their corners."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from orusd_scans.surfaces import as_cloud

CORNERS = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0]])


def triangle() -> Cloud:
    return Cloud(CORNERS, label=np.array([1, 2, 3], "i4"), colors=np.eye(3, dtype="u1"))


def test_a_triangle_is_covered_evenly() -> None:
    cloud, notes = as_cloud(triangle(), np.array([[0, 1, 2]]), 0.01)
    samples = cloud.points[3:]
    assert notes == ()
    assert len(samples) == pytest.approx(3.0 / 0.01**2, abs=1)
    assert samples.mean(axis=0) == pytest.approx(CORNERS.mean(axis=0), abs=0.02)
    # Second moments of a uniform triangle about a corner: a^2 / 6 along each leg.
    assert (samples[:, :2] ** 2).mean(axis=0) == pytest.approx([4 / 6, 9 / 6], rel=0.02)
    assert (samples[:, 0] / 2 + samples[:, 1] / 3 <= 1 + 1e-12).all()
    assert (cloud.normals == [0, 0, 1]).all()


def test_samples_are_of_their_nearest_corner() -> None:
    cloud, _ = as_cloud(triangle(), np.array([[0, 1, 2]]), 0.05)
    # Nearest in the triangle's own coordinates, which is a third of its area each.
    assert np.bincount(cloud.label)[1:] / len(cloud) == pytest.approx([1 / 3] * 3, abs=0.05)
    assert (cloud.colors[np.arange(len(cloud)), cloud.label - 1] == 1).all()


def test_a_dense_mesh_stays_nearly_as_it_is() -> None:
    x, y = np.meshgrid(np.arange(50) * 0.01, np.arange(50) * 0.01, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], -1)
    at = np.arange(2500).reshape(50, 50)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    cloud, _ = as_cloud(Cloud(points), faces, 0.02)
    assert len(cloud) - 2500 == pytest.approx(0.49**2 / 0.02**2, rel=0.15)
    assert cloud.normals[:, 2] == pytest.approx(np.ones(len(cloud)))


def test_an_endless_plane_is_sampled_with_larger_steps() -> None:
    cloud, notes = as_cloud(Cloud(100 * CORNERS), np.array([[0, 1, 2]]), 0.01)
    assert len(cloud) == pytest.approx(2_000_000, rel=0.01)
    assert "12.2 cm apart" in notes[0]


def test_broken_corners_and_lines_give_no_samples() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [np.nan, 1, 0], [1e300, 0, 0]])
    faces = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 0, 0]])
    cloud, _ = as_cloud(Cloud(points), faces)
    assert len(cloud) == len(points)
