"""Walls as convex pieces: exact, whole, and never in a hole."""

import numpy as np
import pytest

from openrooms_usd.building.shell import Hole, slab, wall_solid
from openrooms_usd.building.walls import walls_of
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import box, sphere
from openrooms_usd.geometry.triangulation import TriangleMesh, triangulate
from openrooms_usd.physics.hulls import half_spaces
from openrooms_usd.physics.panels import panel_pieces, slab_pieces

ROOM = np.array([[0, 0], [5.6, 0], [5.6, 3.2], [4.6, 4.4], [2.0, 4.4], [2.0, 3.0], [0, 3.0]])
HEIGHT = 2.6
HOLES = [Hole(0.3, 1.2, 0.0, 2.05), Hole(1.3, 1.9, 0.8, 2.2), Hole(2.2, 2.8, 1.0, 1.5)]


def triangles(mesh: Mesh) -> TriangleMesh:
    corners, faces = triangulate(mesh.points, mesh.counts, mesh.indices)
    return TriangleMesh(mesh.points, mesh.indices[corners], faces)


def inside(piece: TriangleMesh, points: np.ndarray) -> np.ndarray:
    planes = half_spaces(piece)
    return (points @ planes[:, :3].T + planes[:, 3] <= 1e-9).all(axis=1)


@pytest.mark.parametrize("number", range(len(ROOM)))
@pytest.mark.parametrize("holes", [0, 1, 2])
def test_pieces_fill_the_wall_and_leave_its_holes_open(number: int, holes: int) -> None:
    wall = walls_of(ROOM, np.arange(len(ROOM)), 0.24)[number]
    fitting = [hole for hole in HOLES if hole.right < wall.length - 0.5][:holes]
    pieces = panel_pieces(triangles(wall_solid(wall, HEIGHT, fitting)))
    assert pieces
    rng = np.random.default_rng(number)
    local = rng.uniform([0.0, 0.0, 0.0], [wall.length, wall.thickness, HEIGHT], (2000, 3))
    # Only where the wall surely is: its ends are mitred.
    sure = (local[:, 0] > 0.25) & (local[:, 0] < wall.length - 0.25)
    points = np.column_stack([wall.to_plan(local[:, :2]), local[:, 2]])[sure]
    x, _, z = local[sure].T
    free = np.zeros(len(x), dtype=bool)
    for hole in fitting:
        free |= (x > hole.left) & (x < hole.right) & (z > hole.bottom) & (z < hole.top)
    taken = np.sum([inside(piece, points) for piece in pieces], axis=0)
    np.testing.assert_array_equal(taken > 0, ~free)


def test_what_is_no_wall_has_no_pieces() -> None:
    assert panel_pieces(triangles(sphere(1.0))) == []
    mesh = triangles(box((1, 1, 1)))
    turned = mesh.points @ np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    assert panel_pieces(TriangleMesh(turned, mesh.triangles, mesh.faces)) == []


def test_a_floor_is_the_prism_over_the_hull_of_its_plan() -> None:
    floor = triangles(slab(ROOM, 0.24, -0.24, 0.0))
    (hull,) = slab_pieces(floor)
    assert set(np.unique(hull.points[:, 2])) == {-0.24, 0.0}
    assert inside(hull, floor.points).all()
    a, b, c = np.moveaxis(hull.points[hull.triangles], 1, 0)
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
    assert volume > 0.0


def test_a_cut_beside_a_corner_makes_no_second_one() -> None:
    """Float32 moves the corners of a slanting wall's hole off its outline, and its sides too."""
    for number, wall in enumerate(walls_of(ROOM, np.arange(len(ROOM)), 0.24)):
        solid = triangles(wall_solid(wall, HEIGHT, [Hole(0.333, 1.234, 0.0, 2.05)]))
        stored = TriangleMesh(
            solid.points.astype(np.float32).astype(np.float64), solid.triangles, solid.faces
        )
        for piece in panel_pieces(stored):
            a, b, c = np.moveaxis(piece.points.astype(np.float32)[piece.triangles], 1, 0)
            areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
            assert areas.min() > 1e-6, number
