"""Computed normals against shapes whose normals are known; the cube projection."""

import numpy as np
import pytest

from openrooms_usd.geometry import normals as module
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import face_vectors, with_normals
from openrooms_usd.geometry.solids import box, rounded_box, sphere
from openrooms_usd.geometry.uv import cube_projection


def _bare(mesh: Mesh) -> Mesh:
    return Mesh(mesh.points, mesh.counts, mesh.indices)


def test_a_sphere_gets_radial_normals() -> None:
    mesh = with_normals(_bare(sphere(2, segments=64)))
    radial = mesh.points[mesh.indices] / 2
    assert np.einsum("ij,ij->i", radial, mesh.normals).min() > 0.999


def test_the_edges_of_a_box_stay_sharp() -> None:
    mesh = with_normals(_bare(box((1, 2, 3))))
    np.testing.assert_allclose(np.abs(mesh.normals).max(axis=1), 1.0)


def test_large_faces_stay_flat_beside_small_bevels() -> None:
    mesh = with_normals(_bare(rounded_box((1, 1, 1), 0.003)))
    large = np.repeat(mesh.areas() > 0.5, mesh.counts)
    assert np.abs(mesh.normals[large]).max(axis=1).min() > 0.99995


def test_blocks_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = _bare(sphere(1))
    whole = with_normals(mesh).normals
    monkeypatch.setattr(module, "_BLOCK", 50)
    np.testing.assert_array_equal(with_normals(mesh).normals, whole)


def test_projected_areas_follow_the_cosine() -> None:
    mesh = cube_projection(sphere(1))
    flat = np.concatenate([mesh.st, np.zeros((len(mesh.st), 1))], axis=1)
    loose = Mesh(flat, mesh.counts, np.arange(len(flat), dtype=np.int32))
    vectors = face_vectors(mesh)
    expected = np.abs(vectors).max(axis=1)
    mapped = face_vectors(loose)
    np.testing.assert_allclose(np.linalg.norm(mapped, axis=1), expected, atol=1e-6)
    # No picture is mirrored, from whichever side it is seen.
    assert (mapped[:, 2] > 0).all()
