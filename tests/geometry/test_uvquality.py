"""Density and stretch of texture coordinates, against maps whose values are known."""

from dataclasses import replace

import numpy as np
import pytest

from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import box, sphere
from openrooms_usd.geometry.uv import cube_projection
from openrooms_usd.geometry.uvquality import MOST_STRETCH, densities, uv_quality


def _sheet(width: float, depth: float, st: object) -> Mesh:
    """One rectangle in the plane x + y + z = const, so that no axis is special."""
    along, up = np.array([1.0, -1.0, 0.0]) / np.sqrt(2), np.array([1.0, 1.0, -2.0]) / np.sqrt(6)
    corners = [0 * along, width * along, width * along + depth * up, depth * up]
    return Mesh(
        np.array(corners),
        np.array([4], np.int32),
        np.arange(4, dtype=np.int32),
        st=np.array(st, dtype=np.float32),
    )


UNIT = [[0, 0], [1, 0], [1, 1], [0, 1]]


def test_the_singular_values_are_those_of_lapack() -> None:
    rng = np.random.default_rng(4)
    points, st = rng.normal(size=(300, 3)), rng.normal(size=(300, 2)).astype(np.float32)
    mesh = Mesh(points, np.full(100, 3, np.int32), np.arange(300, dtype=np.int32), st=st)
    found, areas = densities(mesh)
    for triangle in range(100):
        a, b, c = points[3 * triangle : 3 * triangle + 3]
        at, bt, ct = st[3 * triangle : 3 * triangle + 3].astype(float)
        edges = np.stack([b - a, c - a], axis=1)
        frame, _ = np.linalg.qr(edges)
        jacobian = np.stack([bt - at, ct - at], axis=1) @ np.linalg.inv(frame.T @ edges)
        expected = np.linalg.svd(jacobian, compute_uv=False)
        np.testing.assert_allclose(found[triangle], expected, rtol=1e-9)
        determinant = np.linalg.det(frame.T @ edges)
        assert areas[triangle] == pytest.approx(abs(determinant) / 2)


@pytest.mark.parametrize("ratio", [1.0, 1.5, 4.0])
def test_an_even_stretch_has_its_closed_form(ratio: float) -> None:
    quality = uv_quality(_sheet(2.0 * ratio, 2.0, UNIT))
    assert quality.density == pytest.approx(0.5 / np.sqrt(ratio), rel=1e-6)
    assert quality.greatest == pytest.approx(0.5, rel=1e-6)
    assert quality.least == pytest.approx(0.5 / ratio, rel=1e-6)
    assert quality.stretch == pytest.approx(np.sqrt(0.5 * (ratio + 1.0 / ratio)), rel=1e-6)
    assert bool(quality.fault) == (quality.stretch > MOST_STRETCH) == (ratio == 4.0)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_the_cube_projection_keeps_within_its_bounds_at_every_size(size: float) -> None:
    quality = uv_quality(cube_projection(sphere(size, segments=64)))
    assert quality.greatest == pytest.approx(1.0, abs=1e-4)
    assert 1.0 / np.sqrt(3.0) - 1e-4 < quality.least < 0.65
    assert 1.0 < quality.stretch < 1.03
    assert quality.folded == 0.0
    assert not quality.fault


def test_scaling_a_mesh_and_not_its_coordinates_changes_the_density_alone() -> None:
    mesh = cube_projection(sphere(1))
    one, ten = uv_quality(mesh), uv_quality(replace(mesh, points=10.0 * mesh.points))
    assert ten.density == pytest.approx(0.1 * one.density)
    assert ten.stretch == pytest.approx(one.stretch)


def test_degenerate_triangles_in_the_texture_are_a_part_of_the_area() -> None:
    mesh = cube_projection(box((1, 1, 1)))
    assert mesh.st is not None
    st = mesh.st.copy()
    st[:4] = st[0]  # one of six equal faces becomes a point
    folded = uv_quality(replace(mesh, st=st))
    assert folded.folded == pytest.approx(1.0 / 6.0)
    assert folded.stretch == pytest.approx(1.0, abs=1e-6)
    assert "16.7 % of the surface has no place" in folded.fault
    nowhere = uv_quality(replace(mesh, st=np.zeros_like(st)))
    assert (nowhere.folded, nowhere.stretch) == (1.0, np.inf)
    assert nowhere.fault


def test_degenerate_triangles_of_the_surface_count_for_nothing() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    indices = np.array([0, 1, 2, 0, 0, 1, 2, 2, 2], np.int32)
    st = np.array([[0, 0], [1, 0], [0, 1], *[[5, 5], [9, 1], [0, 7]] * 2], np.float32)
    mesh = Mesh(points, np.full(3, 3, np.int32), indices, st=st)
    quality = uv_quality(mesh)
    assert (quality.density, quality.stretch, quality.folded) == pytest.approx((1.0, 1.0, 0.0))
    assert np.isfinite(densities(mesh)[0]).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_coordinates_that_are_no_numbers(bad: float) -> None:
    quality = uv_quality(_sheet(1, 1, [[0, 0], [1, 0], [1, bad], [0, 1]]))
    assert quality.fault == "they are not finite"


def test_wrong_units_are_found() -> None:
    assert "0.00001" in f"{uv_quality(_sheet(1e5, 1e5, UNIT)).density:.5f}"
    assert "metre" in uv_quality(_sheet(1e5, 1e5, UNIT)).fault
