"""The error of collision shapes against closed forms and against trimesh."""

import numpy as np
import pytest
import trimesh

from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.collision_error import collision_error, volumes
from openrooms_usd.physics.components import Part, components
from openrooms_usd.physics.hulls import convex_hull
from openrooms_usd.physics.solid import Solid
from openrooms_usd.physics.surfaces import Surface


def thing(mesh: trimesh.Trimesh) -> Solid:
    return Solid(components([Part("thing", mesh.vertices, mesh.faces)]))


def shape(mesh: trimesh.Trimesh) -> TriangleMesh:
    return convex_hull(mesh.vertices, vertices=4096)


def box(*sides: float, at: tuple[float, float, float] = (0, 0, 0)) -> trimesh.Trimesh:
    return trimesh.creation.box(sides, trimesh.transformations.translation_matrix(at))


def test_distances_are_those_of_trimesh() -> None:
    mesh = trimesh.creation.torus(0.03, 0.01, major_sections=24, minor_sections=12)
    points = np.random.default_rng(0).uniform(-0.6, 0.6, (400, 3))
    found = Surface(mesh.triangles).nearest(points)
    triangles = np.repeat(np.arange(len(mesh.faces))[None], len(points), axis=0)
    feet = trimesh.triangles.closest_point(
        mesh.triangles[triangles.ravel()], np.repeat(points, len(mesh.faces), axis=0)
    ).reshape(len(points), -1, 3)
    expected = np.linalg.norm(feet - points[:, None], axis=2).min(axis=1)
    assert found.distance == pytest.approx(expected, abs=1e-9)


def test_the_inside_is_that_of_the_closed_form() -> None:
    mesh = trimesh.creation.torus(0.3, 0.1, major_sections=96, minor_sections=48)
    points = np.random.default_rng(1).uniform(-0.4, 0.4, (3000, 3))
    tube = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 0.3, points[:, 2])
    clear = np.abs(tube - 0.1) > 2e-3
    assert (thing(mesh).inside(points) == (tube < 0.1))[clear].all()


def test_a_box_that_is_too_large() -> None:
    error = collision_error([shape(box(1.2, 1.0, 1.0))], thing(box(1, 1, 1)))
    assert error.protrusion == pytest.approx(0.1, abs=1e-3 + 1e-9)
    assert error.uncovered <= 1e-3
    assert error.slack <= 1e-3 + 1e-9


def test_a_box_that_is_too_small() -> None:
    error = collision_error([shape(box(1, 1, 0.8))], thing(box(1, 1, 1)))
    assert error.uncovered == pytest.approx(0.1, abs=1e-3 + 1e-9)
    assert error.protrusion <= 1e-3


def test_a_filled_hollow_shows_also_under_a_lid() -> None:
    walls = [box(1, 1, 0.02, at=(0, 0, z)) for z in (-0.49, 0.49)]
    walls += [box(0.02, 1, 1, at=(x, 0, 0)) for x in (-0.49, 0.49)]
    tube = trimesh.util.concatenate(walls)
    # The hull's open ends lie half of the inner width away from the walls.
    error = collision_error([shape(tube)], thing(tube))
    assert error.protrusion == pytest.approx(0.48, abs=1e-3 + 1e-9)


def test_the_error_of_a_torus_hull_is_its_radius() -> None:
    mesh = trimesh.creation.torus(0.3, 0.1, major_sections=24, minor_sections=12)
    error = collision_error([shape(mesh)], thing(mesh))
    # The middle of the disc that closes the hole.
    assert error.protrusion == pytest.approx(np.hypot(0.3, 0.1) - 0.1, rel=0.01)


def test_the_hull_of_few_corners_misses_a_sphere_by_its_sagitta() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=0.1)
    octahedron = trimesh.convex.convex_hull(0.1 * np.concatenate([np.eye(3), -np.eye(3)]))
    error = collision_error([shape(octahedron)], thing(sphere))
    # The middle of a face lies at 1 / sqrt(3) of the radius from the centre.
    assert error.uncovered == pytest.approx(0.1 - 0.1 / np.sqrt(3.0), abs=1.6e-3)
    assert error.protrusion <= 1e-3


def test_turned_sheets_and_inverted_meshes_count_alike() -> None:
    mesh = box(1, 1, 1)
    inverted = trimesh.Trimesh(mesh.vertices, mesh.faces[:, ::-1], process=False)
    error = collision_error([shape(box(0.5, 0.5, 0.5))], thing(inverted))
    assert error.protrusion <= 1e-3


def test_volumes_of_what_overlaps_count_once() -> None:
    shapes = [shape(box(1, 1, 1)), shape(box(1, 1, 1, at=(0.5, 0, 0)))]
    found = volumes(shapes, thing(box(1, 1, 1)))
    assert found.shapes == pytest.approx(1.5, rel=1e-9)
    assert abs(found.thing - 1.0) < 4 * found.thing_error
    assert found.thing_error < 0.01
