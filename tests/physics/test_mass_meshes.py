"""Meshes as people have them: open, split, cracked, wound anyhow, tiny, flat, broken."""

import numpy as np
import pytest
import trimesh

from openrooms_usd.errors import InputError
from openrooms_usd.physics.inertia import shell, solid

BOX = trimesh.creation.box((1.0, 2.0, 3.0))
WHOLE = solid(BOX.vertices, BOX.faces, 100.0)


def assert_the_box(points, faces, notes=()):
    found = solid(points, faces, 100.0)
    assert found.mass == pytest.approx(WHOLE.mass)
    np.testing.assert_allclose(found.centre, WHOLE.centre, atol=1e-6)
    np.testing.assert_allclose(found.inertia, WHOLE.inertia, rtol=1e-6, atol=1e-5)
    assert found.notes == notes


def test_triangles_that_share_no_points_hang_together_by_their_places():
    assert_the_box(BOX.triangles.reshape(-1, 3), np.arange(36).reshape(-1, 3))


def test_triangles_wound_anyhow_are_turned_alike():
    rng = np.random.default_rng(2)
    for _ in range(20):
        faces = BOX.faces.copy()
        wrong = rng.random(12) < 0.5
        faces[wrong] = faces[wrong][:, ::-1]
        found = solid(BOX.vertices, faces, 100.0)
        assert found.mass == pytest.approx(600.0)
        np.testing.assert_allclose(found.inertia, WHOLE.inertia, atol=1e-9)


def test_a_crack_at_an_edge_of_which_one_side_is_divided_is_no_hole():
    # The first triangle is cut at the middle of an edge; its neighbour is not.
    a, b, c = BOX.faces[0]
    points = np.vstack([BOX.vertices, 0.5 * (BOX.vertices[a] + BOX.vertices[b])])
    assert_the_box(points, np.vstack([[[a, 8, c], [8, b, c]], BOX.faces[1:]]))


def test_degenerate_triangles_change_nothing():
    flat = [[0, 0, 1], [2, 2, 2], [3, 1, 3]]
    assert_the_box(BOX.vertices, np.vstack([BOX.faces, flat]))


def test_points_that_no_triangle_uses_may_be_anything():
    points = np.vstack([BOX.vertices, [[np.nan, 0, 0], [1e9, 0, 0]]])
    assert_the_box(points, BOX.faces)


def test_a_body_without_an_underside_is_closed_and_told():
    faces = BOX.faces[BOX.face_normals[:, 2] > -0.5]
    assert_the_box(BOX.vertices, faces, notes=("holes were closed",))


def test_a_surface_with_a_large_hole_has_no_volume():
    tray = trimesh.creation.box((1.0, 1.0, 0.1))
    faces = tray.faces[tray.face_normals[:, 2] < 0.5]
    with pytest.raises(InputError, match="a surface with holes has no volume"):
        solid(tray.vertices, faces, 100.0)
    found = solid(tray.vertices, faces, 100.0, sheet=0.01)
    assert found.mass == pytest.approx(shell(tray.vertices, faces, 100.0, 0.01).mass)


def test_each_component_is_judged_by_itself():
    sheet = np.array([[5, 0, 0], [6, 0, 0], [6, 1, 0.0]])
    points, faces = np.vstack([BOX.vertices, sheet]), np.vstack([BOX.faces, [[8, 9, 10]]])
    assert solid(points, faces, 100.0, sheet=0.02).mass == pytest.approx(600.0 + 0.5 * 100 * 0.02)


def test_overlapping_components_both_count_also_when_one_is_inside_out():
    other = trimesh.creation.box((1.0, 1.0, 1.0))
    other.vertices += [0.8, 0.0, 0.0]
    for faces in (other.faces, other.faces[:, ::-1]):
        points = np.vstack([BOX.vertices, other.vertices])
        found = solid(points, np.vstack([BOX.faces, faces + 8]), 100.0)
        assert found.mass == pytest.approx(700.0)


@pytest.mark.parametrize(
    "size",
    [
        (0.001, 0.001, 0.001),
        (10.0, 10.0, 10.0),
        (0.001, 0.001, 10.0),
        (3.0, 2.0, 0.0002),
        (1e-6,) * 3,
    ],
)
def test_small_large_thin_and_flat_bodies_are_bodies(size):
    mesh = trimesh.creation.box(size)
    for found in (
        solid(mesh.vertices, mesh.faces, 1000.0),
        shell(mesh.vertices, mesh.faces, 1000.0, 1e-7),
    ):
        found.checked()
    exact = 1000.0 * np.prod(size)
    assert solid(mesh.vertices, mesh.faces, 1000.0).mass == pytest.approx(exact, rel=1e-9)


def test_a_gram_is_a_gram():
    side = 0.01
    mesh = trimesh.creation.box((side,) * 3)
    found = solid(mesh.vertices, mesh.faces, 1000.0).checked()
    assert found.mass == pytest.approx(0.001)
    np.testing.assert_allclose(np.diag(found.inertia), 0.001 * side**2 / 6, rtol=1e-12)


def test_a_strip_of_one_side_has_an_area_and_no_volume():
    turns = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    points = []
    for turn in turns:
        for side in (-0.2, 0.2):
            radius = 1 + side * np.cos(turn / 2)
            points.append([radius * np.cos(turn), radius * np.sin(turn), side * np.sin(turn / 2)])
    quads = [[2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2] for i in range(59)] + [[118, 119, 0, 1]]
    faces = [row for a, b, c, d in quads for row in ([a, b, c], [a, c, d])]
    area = trimesh.Trimesh(points, faces, process=False).area
    found = shell(points, faces, 1000.0, 0.001).checked()
    assert found.mass == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize(
    ("points", "faces", "message"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3)), "no surface"),
        (np.zeros((3, 3)), [[0, 1, 2]], "no surface"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], "no surface"),
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], "not a finite number"),
        ([[0, 0, 0], [1, 0, 0], [0, np.inf, 0]], [[0, 1, 2]], "not a finite number"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]], "not among the mesh's 3 points"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, -1]], "not among the mesh's 3 points"),
    ],
)
def test_what_is_no_mesh_is_said(points, faces, message):
    with pytest.raises(InputError, match=message) as caught:
        shell(points, faces, 1000.0, 0.01)
    assert caught.value.remedy
