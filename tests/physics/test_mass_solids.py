"""Solid bodies and walls against closed forms, another library, and chance."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.physics.inertia import shell, solid
from openrooms_usd.physics.mass import MassProperties, combined

SIZE = np.array([0.3, 0.5, 1.1])
SOMEWHERE = np.array([2.0, -3.0, 0.7])
SOMEHOW = Rotation.from_euler("xyz", [0.3, -1.1, 2.0]).as_matrix()


def box_inertia(mass: float, size: Array) -> Array:
    squares = np.asarray(size) ** 2
    return np.diag(mass / 12.0 * (squares.sum() - squares))


def assert_same(found: MassProperties, mass: float, centre: Array, inertia: Array, rel=1e-12):
    assert found.mass == pytest.approx(mass, rel=rel)
    np.testing.assert_allclose(found.centre, centre, rtol=0, atol=rel * (1 + abs(centre).max()))
    np.testing.assert_allclose(found.inertia, inertia, rtol=0, atol=rel * abs(inertia).max())


def test_a_box_is_its_closed_form_wherever_it_stands():
    mesh = trimesh.creation.box(SIZE)
    mass = 700.0 * np.prod(SIZE)
    found = solid(mesh.vertices @ SOMEHOW.T + SOMEWHERE, mesh.faces, 700.0)
    assert_same(found, mass, SOMEWHERE, SOMEHOW @ box_inertia(mass, SIZE) @ SOMEHOW.T)
    assert found.notes == ()


def test_a_mirrored_box_with_its_winding_left_is_turned_round_and_told():
    mesh = trimesh.creation.box(SIZE)
    mesh.vertices += [1.0, 2.0, 3.0]
    found = solid(mesh.vertices * [-1, 1, 1], mesh.faces, 700.0)
    mass = 700.0 * np.prod(SIZE)
    assert_same(found, mass, np.array([-1.0, 2.0, 3.0]), box_inertia(mass, SIZE))
    assert found.notes == ("a surface that was inside out was turned",)


@pytest.mark.parametrize("offset", [1e3, 1e6])
def test_far_from_the_origin_nothing_is_lost_but_the_points_own_digits(offset):
    mesh = trimesh.creation.box((0.001, 0.002, 0.003))
    found = solid(mesh.vertices + offset, mesh.faces, 7850.0)
    mass = 7850.0 * 6e-9
    # A coordinate of 1e6 m is known to 1e-10 m, which is 1e-7 of a millimetre.
    assert_same(
        found,
        mass,
        np.full(3, offset),
        box_inertia(mass, np.array([0.001, 0.002, 0.003])),
        rel=1e-12 + 1e-12 * offset,
    )


def test_a_tetrahedron_is_its_closed_form():
    # The corner of a cube of side a: centre a / 4, J = 3 m a2 / 40 and m a2 / 80 about the centre.
    points = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]], dtype=float)
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    mass = 500.0 * 8 / 6
    inertia = mass * 4 * (3 / 40 * np.eye(3) + (np.ones((3, 3)) - np.eye(3)) / 80)
    assert_same(solid(points, faces, 500.0), mass, np.full(3, 0.5), inertia)


@pytest.mark.parametrize("sections", [16, 32, 64, 128])
def test_cylinders_converge_with_the_square_of_their_sides(sections):
    radius, height = 0.2, 0.9
    mesh = trimesh.creation.cylinder(radius, height, sections=sections)
    found = solid(mesh.vertices, mesh.faces, 1000.0)
    mass = 1000.0 * np.pi * radius**2 * height
    across = mass * (3 * radius**2 + height**2) / 12
    inertia = np.diag([across, across, mass * radius**2 / 2])
    error = abs(found.inertia - inertia).max() / inertia.max()
    assert found.mass == pytest.approx(mass, rel=7.0 / sections**2)
    assert error < 14.0 / sections**2
    assert error > 1.0 / sections**2  # a polygon inside the circle is lighter


def test_a_ball_converges():
    errors = []
    for level in (2, 3, 4):
        mesh = trimesh.creation.icosphere(level, 0.5)
        found = solid(mesh.vertices, mesh.faces, 2000.0)
        errors.append(1 - found.inertia[0, 0] / (0.4 * 2000.0 * 4 / 3 * np.pi * 0.5**5))
    assert errors[0] < 0.06 and errors[2] < 0.004
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


def test_another_library_finds_the_same_of_a_free_form():
    rng = np.random.default_rng(5)
    mesh = trimesh.creation.icosphere(3)
    mesh.vertices = mesh.vertices * (1 + 0.3 * np.sin(5 * mesh.vertices[:, :1])) * SIZE + SOMEWHERE
    mesh.vertices += 0.002 * rng.standard_normal(mesh.vertices.shape)
    mesh.density = 640.0
    found = solid(mesh.vertices, mesh.faces, 640.0)
    assert_same(found, mesh.mass, mesh.center_mass, mesh.moment_inertia, rel=1e-9)


def test_a_table_is_its_boards_and_legs_by_parallel_axes():
    boards = [((1.4, 0.8, 0.03), (0, 0, 0.725), 600.0)]
    boards += [((0.06, 0.06, 0.71), (x, y, 0.355), 700.0) for x in (-0.6, 0.6) for y in (-0.3, 0.3)]
    pieces, mass, moment = [], 0.0, np.zeros(3)
    for size, centre, density in boards:
        mesh = trimesh.creation.box(size)
        pieces.append(solid(mesh.vertices + centre, mesh.faces, density))
        weight = density * np.prod(size)
        mass, moment = mass + weight, moment + weight * np.array(centre)
    middle, inertia = moment / mass, np.zeros((3, 3))
    for size, centre, density in boards:
        weight, d = density * np.prod(size), np.array(centre) - middle
        inertia += box_inertia(weight, np.array(size)) + weight * (
            d @ d * np.eye(3) - np.outer(d, d)
        )
    assert_same(combined(pieces), mass, middle, inertia)


def test_chance_finds_the_same_of_a_composite():
    ball, block = trimesh.creation.icosphere(3, 0.3), trimesh.creation.box(SIZE)
    ball.vertices += [0.9, 0.1, 0.2]
    whole = combined(
        [solid(ball.vertices, ball.faces, 300.0), solid(block.vertices, block.faces, 900.0)]
    )
    rng, count = np.random.default_rng(11), 200_000
    points = rng.uniform([-0.6, -0.6, -0.6], [1.3, 0.6, 0.6], (count, 3))
    box = 1.9 * 1.2 * 1.2 / count
    in_ball = np.linalg.norm(points - [0.9, 0.1, 0.2], axis=1) < 0.3
    weights = box * (300.0 * in_ball + 900.0 * (abs(points) < SIZE / 2).all(axis=1))
    mass = weights.sum()
    centre = weights @ points / mass
    d = points - centre
    second = np.einsum("n,ni,nj->ij", weights, d, d)
    assert_same(whole, mass, centre, np.trace(second) * np.eye(3) - second, rel=0.02)


def test_a_cavity_weighs_nothing():
    outer, inner = trimesh.creation.box((1, 1, 1)), trimesh.creation.box((0.5, 0.5, 0.5))
    inner.invert()
    both = trimesh.util.concatenate([outer, inner])
    inertia = box_inertia(1000.0, np.ones(3)) - box_inertia(125.0, np.full(3, 0.5))
    for faces in (both.faces, both.faces[:, ::-1]):
        assert_same(solid(both.vertices, faces, 1000.0), 875.0, np.zeros(3), inertia)


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
