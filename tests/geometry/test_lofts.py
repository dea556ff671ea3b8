"""Lofts enclose what the formulas of their solids say."""

import numpy as np
import pytest

from openrooms_usd.geometry.lofts import loft, ring, rounded_rectangle, superellipse, vessel
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.topology import is_closed


def _polygon_area(points: np.ndarray) -> float:
    following = np.roll(points, -1, axis=0)
    return 0.5 * float((points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]).sum())


def _facing(mesh: Mesh) -> np.ndarray:
    """Cosine between each corner's normal and the normal of its first triangle's face."""
    corners, faces = mesh.triangles()
    a, b, c = np.moveaxis(mesh.points[mesh.indices[corners]], 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first = np.searchsorted(faces, np.arange(len(mesh.counts)))
    return np.einsum("ij,ij->i", np.repeat(normal[first], mesh.counts, axis=0), mesh.normals)


def test_a_stack_of_two_squares_is_a_box() -> None:
    flat = rounded_rectangle(2.0, 3.0, 0.0, segments=0)
    mesh = loft([ring(flat, 0.0), ring(flat, 4.0)])
    assert is_closed(mesh)
    assert mesh.volume() == pytest.approx(24)
    assert mesh.areas().sum() == pytest.approx(2 * (6 + 8 + 12))
    assert _facing(mesh).min() == pytest.approx(1)


def test_a_pyramid_cut_off_has_the_volume_of_a_frustum() -> None:
    flat = rounded_rectangle(2.0, 2.0, 0.0, segments=0)
    mesh = loft([ring(flat, 0.0), ring(0.5 * flat, 3.0)])
    assert mesh.volume() == pytest.approx(3.0 * (4.0 + 1.0 + 2.0) / 3.0)


def test_a_closed_loft_has_its_hole_left_out() -> None:
    outer, inner = superellipse(4.0, 4.0), superellipse(2.0, 2.0)
    mesh = loft(
        [ring(outer, 0.0), ring(outer, 1.0), ring(inner, 1.0), ring(inner, 0.0)], closed=True
    )
    assert is_closed(mesh)
    assert mesh.volume() == pytest.approx(_polygon_area(outer) - _polygon_area(inner))


def test_a_vessel_holds_what_its_inside_measures() -> None:
    mesh = vessel((0, 0, 0, 3, 2, 1), (0.1, 0.2, 0.3, 2.8, 1.7), wall_edge=1e-5)
    assert is_closed(mesh)
    assert mesh.volume() == pytest.approx(3 * 2 * 1 - 2.7 * 1.5 * 0.7, rel=1e-4)
    np.testing.assert_allclose(mesh.extent, [[0, 0, 0], [3, 2, 1]], atol=1e-12)


def test_rounded_vessels_stay_closed() -> None:
    mesh = vessel((0, 0, 0, 3, 2, 1), (0.1, 0.1, 0.1, 2.9, 1.9), corner=0.05, inner_corner=0.0)
    assert is_closed(mesh)
    assert mesh.areas().min() > 0


@pytest.mark.parametrize("power", [1.0, 2.0, 2.5, 6.0])
def test_superellipses_fulfil_their_equation(power: float) -> None:
    points = superellipse(3.0, 1.0, power, 64)
    x, y = np.abs(points).T / [[1.5], [0.5]]
    np.testing.assert_allclose(x**power + y**power, 1.0)
    assert _polygon_area(points) > 0


def test_rounded_rectangles_lose_their_corners_area() -> None:
    outline = rounded_rectangle(3.0, 2.0, 0.5, segments=64)
    assert _polygon_area(outline) == pytest.approx(6 - (4 - np.pi) * 0.25, rel=1e-4)


def test_a_front_is_textured_as_it_is_seen() -> None:
    flat = rounded_rectangle(2.0, 2.0, 0.0, segments=0)
    mesh = loft([ring(flat, 0.0), ring(flat, 1.0), ring(0.5 * flat, 1.0), ring(0.5 * flat, 0.9)])
    above = mesh.points[mesh.indices, :2]
    upward = mesh.normals[:, 2] > 0.9
    np.testing.assert_allclose(mesh.st[upward], above[upward], atol=1e-6)
    assert upward.sum() == 4 * 4 + 4
