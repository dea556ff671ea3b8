"""Walls against the closed forms of hollow bodies, and between the sheet and the solid."""

import numpy as np
import pytest
import trimesh

from openrooms_usd.errors import InputError
from openrooms_usd.physics.inertia import shell, solid


def hollow(outer: trimesh.Trimesh, inner: trimesh.Trimesh, density: float) -> trimesh.Trimesh:
    """The body between two surfaces, as another library weighs it."""
    turned = inner.copy()
    turned.invert()
    body = trimesh.util.concatenate([outer, turned])
    body.density = density
    return body


@pytest.mark.parametrize("wall", [0.001, 0.01, 0.05, 0.15])
def test_a_hollow_box_has_its_mass_and_nearly_its_inertia(wall):
    size = np.array([0.4, 0.6, 1.0])
    box = trimesh.creation.box(size)
    found = shell(box.vertices, box.faces, 800.0, wall)
    exact = hollow(box, trimesh.creation.box(size - 2 * wall), 800.0)
    assert found.mass == pytest.approx(exact.mass, rel=1e-9)
    error = abs(found.inertia - exact.moment_inertia).max()
    assert error < 800.0 * 2 * wall**5 + 1e-12


@pytest.mark.parametrize("wall", [0.002, 0.02, 0.1, 0.4])
def test_a_hollow_ball_is_its_closed_form(wall):
    ball = trimesh.creation.icosphere(5, 0.5)
    found = shell(ball.vertices, ball.faces, 1000.0, wall)
    exact = 4 / 3 * np.pi * (0.5**3 - (0.5 - wall) ** 3)
    turning = 8 / 15 * np.pi * (0.5**5 - (0.5 - wall) ** 5)
    assert found.mass == pytest.approx(1000.0 * exact, rel=1.5e-3)  # the ball is of triangles
    assert found.inertia[0, 0] == pytest.approx(1000.0 * turning, rel=3e-3 + 10 * wall**5)


def test_a_tube_with_ends_is_its_closed_form():
    radius, height, wall = 0.3, 1.2, 0.01
    tube = trimesh.creation.cylinder(radius, height, sections=256)
    found = shell(tube.vertices, tube.faces, 900.0, wall)
    inner = trimesh.creation.cylinder(radius - wall, height - 2 * wall, sections=256)
    exact = hollow(tube, inner, 900.0)
    assert found.mass == pytest.approx(exact.mass, rel=2e-4)
    np.testing.assert_allclose(np.diag(found.inertia), np.diag(exact.moment_inertia), rtol=5e-4)


def test_rounded_edges_cost_less_than_a_hundredth():
    from openrooms_usd.geometry.solids import rounded_box
    from openrooms_usd.geometry.triangulation import triangulate

    mesh = rounded_box(np.array([1.0, 0.5, 0.8]), 0.002)
    rows = mesh.indices[triangulate(mesh.points, mesh.counts, mesh.indices)[0]]
    found = shell(mesh.points, rows, 650.0, 0.018)
    exact = 650.0 * (0.4 - 0.964 * 0.464 * 0.764)
    assert found.mass == pytest.approx(exact, rel=0.01)


@pytest.mark.parametrize("wall", [0.009, 0.01, 0.018, 0.1, 1.0])
def test_a_wall_that_fills_its_body_is_the_body(wall):
    board = trimesh.creation.box((0.018, 0.4, 0.6))
    full = solid(board.vertices, board.faces, 600.0)
    found = shell(board.vertices, board.faces, 600.0, wall)
    assert found.mass == full.mass
    np.testing.assert_array_equal(found.inertia, full.inertia)


@pytest.mark.slow
def test_no_shell_is_heavier_than_its_solid_and_thicker_ones_are_heavier():
    ball, ring = trimesh.creation.icosphere(2, 0.2), trimesh.creation.torus(0.4, 0.05)
    rod, pill = trimesh.creation.cylinder(0.02, 0.7), trimesh.creation.capsule(0.5, 0.1)
    for mesh in (ball, ring, rod, pill):
        full = solid(mesh.vertices, mesh.faces, 1000.0).mass
        walls = np.geomspace(1e-4, 2.0, 25)
        masses = [shell(mesh.vertices, mesh.faces, 1000.0, t).checked().mass for t in walls]
        assert (np.diff(masses) > -1e-9).all()
        assert masses[-1] == pytest.approx(full) and max(masses) <= full * (1 + 1e-9)


def test_an_open_sheet_is_a_plate():
    points = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], dtype=float)
    found = shell(points, [[0, 1, 2], [0, 2, 3]], 1000.0, 0.01)
    assert found.mass == pytest.approx(20.0)
    np.testing.assert_allclose(found.centre, [1.0, 0.5, 0.0], atol=1e-12)
    squares = np.array([4.0, 1.0, 0.0001])
    np.testing.assert_allclose(
        found.inertia, np.diag(20 / 12 * (squares.sum() - squares)), atol=1e-9
    )
    found.checked()


def test_a_sheet_that_is_modelled_from_both_sides_weighs_once():
    points = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], dtype=float)
    front = [[0, 1, 2], [0, 2, 3]]
    both = [*front, *[row[::-1] for row in front]]
    once, twice = (shell(points, faces, 1000.0, 0.01) for faces in (front, both))
    assert twice.mass == pytest.approx(once.mass)
    np.testing.assert_allclose(twice.inertia, once.inertia)


def test_an_open_box_has_five_walls():
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    faces = box.faces[box.face_normals[:, 2] < 0.5]
    assert shell(box.vertices, faces, 1000.0, 0.001).mass == pytest.approx(5.0, rel=0.01)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_what_no_wall_can_be_is_said(value):
    box = trimesh.creation.box((1, 1, 1))
    with pytest.raises(InputError, match="thickness of a wall"):
        shell(box.vertices, box.faces, 1000.0, value)
    with pytest.raises(InputError, match="density"):
        solid(box.vertices, box.faces, value)


def test_boxes_that_touch_in_a_corner_have_their_own_walls():
    one, other = trimesh.creation.box((1.0, 1.0, 1.0)), trimesh.creation.box((1.0, 1.0, 1.0))
    other.vertices += 1.0
    both = trimesh.util.concatenate([one, other])
    alone = shell(one.vertices, one.faces, 500.0, 0.05)
    assert shell(both.vertices, both.faces, 500.0, 0.05).mass == pytest.approx(2 * alone.mass)
