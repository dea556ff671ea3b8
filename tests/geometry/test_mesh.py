"""The plain mesh: areas, volumes and transforms against closed forms."""

import numpy as np
import pytest

from openrooms_usd.geometry.mesh import Mesh, joined

CUBE_POINTS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
CUBE_FACES = np.array(
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
)


def cube() -> Mesh:
    normals = np.repeat(
        np.array([[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]]), 4, axis=0
    )
    return Mesh(
        CUBE_POINTS,
        np.full(6, 4, dtype=np.int32),
        CUBE_FACES.ravel().astype(np.int32),
        normals.astype(np.float32),
    )


def winding_normals(mesh: Mesh) -> np.ndarray:
    corners, _ = mesh.triangles()
    a, b, c = np.moveaxis(mesh.points[mesh.indices[corners]], 1, 0)
    return np.cross(b - a, c - a)


def test_a_unit_cube_has_unit_faces_and_unit_volume() -> None:
    assert cube().areas() == pytest.approx(np.ones(6))
    assert cube().volume() == pytest.approx(1.0)


def test_a_scaled_sheared_cube_has_the_volume_of_the_determinant() -> None:
    matrix = np.array([[2.0, 0.5, 0], [0, 3.0, 0.2], [0, 0, 0.5]])
    assert cube().transformed(matrix).volume() == pytest.approx(3.0)


def test_a_mirror_keeps_the_volume_positive_and_the_normals_on_the_winding_side() -> None:
    mirrored = cube().transformed(np.diag([-1.0, 2.0, 1.0]))
    assert mirrored.volume() == pytest.approx(2.0)
    corners, _ = mirrored.triangles()
    assert mirrored.normals is not None
    sides = np.einsum("ij,ij->i", winding_normals(mirrored), mirrored.normals[corners[:, 0]])
    assert np.all(sides > 0)


def test_normals_of_a_sheared_cube_stay_perpendicular_to_its_faces() -> None:
    sheared = cube().transformed(np.array([[1.0, 0.7, 0], [0, 1.0, 0], [0, 0, 1.0]]))
    corners, _ = sheared.triangles()
    assert sheared.normals is not None
    face = winding_normals(sheared)
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    assert sheared.normals[corners[:, 0]] == pytest.approx(face, abs=1e-6)


def test_joined_meshes_keep_their_volume_and_indices_apart() -> None:
    both = joined([cube(), cube().moved([3, 0, 0])])
    assert both.volume() == pytest.approx(2.0)
    assert both.extent.tolist() == [[0, 0, 0], [4, 1, 1]]
