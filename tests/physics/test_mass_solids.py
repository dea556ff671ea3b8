"""Solid bodies against closed forms, another library, and chance."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from openrooms_usd.physics.inertia import solid
from openrooms_usd.physics.mass import MassProperties, combined

Array = NDArray[np.float64]
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
