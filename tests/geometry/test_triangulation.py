"""Triangulation against shapely's areas, in any plane."""

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.triangulation import TriangleMesh, bounding_box, has_area, triangulate


def star(rng: np.random.Generator, corners: int) -> Array:
    """(N, 2) a simple polygon with reflex corners, counter-clockwise."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, corners - 3))
    angles = np.sort(np.concatenate([angles, [0.1, 2.2, 4.3]]))
    radii = rng.uniform(0.2, 2.0, corners)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)


def tilted(rng: np.random.Generator, plan: Array) -> tuple[Array, Array]:
    """The polygon somewhere in space, and its normal."""
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    return plan @ rotation[:, :2].T + rng.uniform(-1e3, 1e3, 3), rotation[:, 2]


def one_face(points: Array) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    count = len(points)
    return np.array([count], dtype=np.int32), np.arange(count, dtype=np.int32)


@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), corners=st.integers(4, 24))
def test_any_simple_polygon_is_covered_once(seed: int, corners: int) -> None:
    rng = np.random.default_rng(seed)
    plan = star(rng, corners)
    points, normal = tilted(rng, plan)
    cut, faces = triangulate(points, *one_face(points))
    a, b, c = np.moveaxis(points[cut], 1, 0)
    areas = np.cross(b - a, c - a) @ normal / 2.0
    polygon = shapely.Polygon(plan)
    assert (areas > 0).all()  # its own winding
    np.testing.assert_allclose(areas.sum(), polygon.area, rtol=1e-9)
    grown = polygon.buffer(1e-9)
    assert all(grown.covers(shapely.Polygon(plan[row])) for row in cut)
    assert (faces == 0).all()


@pytest.mark.parametrize("dent", range(4))
def test_a_dented_quad_is_cut_at_its_dent(dent: int) -> None:
    plan = np.array([[0.0, 0, 0], [2, 0, 0], [0.4, 0.4, 0], [0, 2, 0]])
    points = np.roll(plan, dent, axis=0)
    cut, _ = triangulate(points, *one_face(points))
    areas = np.cross(points[cut[:, 1]] - points[cut[:, 0]], points[cut[:, 2]] - points[cut[:, 0]])
    np.testing.assert_allclose(areas[:, 2].sum() / 2, shapely.Polygon(plan[:, :2]).area)
    assert (areas[:, 2] > 0).all()


def test_mixed_faces_keep_their_numbers_and_order() -> None:
    plan = np.array([[0.0, 0], [4, 0], [4, 1], [1, 1], [1, 2], [4, 2], [4, 3], [0, 3]])  # a C
    points = np.concatenate(
        [np.c_[plan, np.zeros(8)], [[9, 0, 0], [10, 0, 0], [10, 1, 0], [9, 1, 0]]]
    )
    counts = np.array([3, 8, 2, 4, 0], dtype=np.int32)
    indices = np.array([8, 9, 10, *range(8), 0, 1, 8, 9, 10, 11], dtype=np.int32)
    cut, faces = triangulate(points, counts, indices)
    assert faces.tolist() == [0] + [1] * 6 + [3] * 2
    corner_faces = np.repeat(np.arange(5), counts)
    assert (corner_faces[cut] == faces[:, None]).all()


def test_triangles_without_area_are_left_out() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0]]) + 1000.0
    counts = np.array([3, 3, 4], dtype=np.int32)
    indices = np.array([0, 1, 2, 1, 1, 3, 0, 1, 2, 3], dtype=np.int32)
    cut, faces = triangulate(points, counts, indices)
    assert set(faces.tolist()) == {2}
    assert has_area(points[indices[cut]]).all()
    doubled = np.linalg.norm(
        np.cross(*(points[indices[cut[:, k]]] - points[indices[cut[:, 0]]] for k in (1, 2))), axis=1
    )
    np.testing.assert_allclose(doubled.sum() / 2.0, 1.0)


def test_a_thousandth_of_a_millimetre_is_still_an_area() -> None:
    assert has_area(np.array([[[0.0, 0, 0], [1e-6, 0, 0], [0, 1e-6, 0]]])).all()


def test_a_bounding_box_is_closed_and_tight() -> None:
    points = np.random.default_rng(0).normal(size=(50, 3))
    box = bounding_box(TriangleMesh(points, np.zeros((0, 3), np.int32), np.zeros(0, np.int32)))
    found = trimesh.Trimesh(box.points, box.triangles)
    assert found.is_watertight
    np.testing.assert_allclose(found.bounds, [points.min(axis=0), points.max(axis=0)])
    assert found.volume == pytest.approx(np.prod(np.ptp(points, axis=0)))
