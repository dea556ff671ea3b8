"""Masses of meshes as people have them: frames, sums, scales, and what no body can have."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from openrooms_usd.errors import InputError
from openrooms_usd.physics.inertia import shell, solid
from openrooms_usd.physics.mass import MassProperties, combined

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


BLOB = trimesh.creation.icosphere(2)
BLOB.vertices = BLOB.vertices * [0.2, 0.5, 0.9] + 0.1 * np.sin(7 * BLOB.vertices[:, [1, 2, 0]])
BLOB.vertices += [1.0, 0.5, -0.2]
PIECE = solid(BLOB.vertices, BLOB.faces, 500.0)
numbers = st.floats(-1.0, 1.0)
quaternions = st.tuples(numbers, numbers, numbers, numbers).filter(
    lambda q: np.linalg.norm(q) > 0.1
)


def assert_equal(a: MassProperties, b: MassProperties, rel=1e-9):
    assert a.mass == pytest.approx(b.mass, rel=rel)
    np.testing.assert_allclose(a.centre, b.centre, rtol=0, atol=rel * (1 + abs(b.centre).max()))
    np.testing.assert_allclose(a.inertia, b.inertia, rtol=0, atol=rel * abs(b.inertia).max())


def rigid(quaternion, offset, mirrored=False):
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    if mirrored:
        matrix[:3, 0] *= -1
    matrix[:3, 3] = offset
    return matrix


@settings(max_examples=40, deadline=None)
@given(quaternions, st.tuples(numbers, numbers, numbers), st.booleans())
def test_moving_the_mass_is_moving_the_mesh(quaternion, offset, mirrored):
    M = rigid(quaternion, offset, mirrored)
    points = BLOB.vertices @ M[:3, :3].T + M[:3, 3]
    assert_equal(PIECE.transformed(M), solid(points, BLOB.faces, 500.0))


@settings(max_examples=40, deadline=None)
@given(st.tuples(*[st.floats(0.01, 100.0)] * 3), st.booleans())
def test_scaling_the_mass_of_a_solid_is_scaling_its_mesh(factors, mirrored):
    S = np.array(factors) * ([-1, 1, 1] if mirrored else 1)
    assert_equal(PIECE.scaled(S), solid(BLOB.vertices * S, BLOB.faces, 500.0))


def test_a_matrix_that_scales_is_refused():
    with pytest.raises(InputError, match="scales or shears"):
        PIECE.transformed(np.diag([2.0, 1.0, 1.0, 1.0]))


def test_a_known_weight_takes_the_inertia_with_it():
    assert_equal(PIECE.weighing(3.0), solid(BLOB.vertices, BLOB.faces, 500.0 * 3.0 / PIECE.mass))
    for kilograms in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match="mass must be positive"):
            PIECE.weighing(kilograms)


def test_a_body_cut_in_two_is_the_sum_of_its_halves():
    low, high = (
        solid(half.vertices, half.faces, 500.0)
        for half in (
            trimesh.creation.box(bounds=[[0, 0, a], [1, 2, b]]) for a, b in ((0, 1), (1, 3))
        )
    )
    whole = trimesh.creation.box(bounds=[[0, 0, 0], [1, 2, 3]])
    assert_equal(combined([low, high]), solid(whole.vertices, whole.faces, 500.0))
    with pytest.raises(InputError, match="without any mass"):
        combined([])


@settings(max_examples=60, deadline=None)
@given(quaternions)
def test_principal_axes_give_the_tensor_back(quaternion):
    found = PIECE.transformed(rigid(quaternion, (0, 0, 0)))
    moments, R = found.principal()
    np.testing.assert_allclose(R @ np.diag(moments) @ R.T, found.inertia, atol=1e-9)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    np.testing.assert_allclose(np.sort(moments), np.sort(PIECE.principal()[0]))


@pytest.mark.parametrize(
    "moments", [(1, 2, 2.5), (2.5, 1, 2), (2, 2, 1), (1, 2, 2), (2, 1, 2), (3, 3, 3)]
)
def test_a_tensor_along_its_axes_keeps_them(moments):
    found, R = MassProperties(1.0, np.zeros(3), np.diag(np.array(moments, float))).principal()
    np.testing.assert_array_equal(R, np.eye(3))
    np.testing.assert_array_equal(found, moments)


@settings(max_examples=60, deadline=None)
@given(quaternions, st.sampled_from([(2.0, 2.0, 1.0), (1.0, 2.0, 2.0), (3.0, 3.0, 3.0)]))
def test_axes_of_repeated_moments_hang_on_the_body_and_not_on_its_last_bits(quaternion, moments):
    R = Rotation.from_quat(quaternion).as_matrix()
    tensor = R @ np.diag(moments) @ R.T
    noise = 1e-13 * np.array([[1, -2, 3], [-2, 4, 1], [3, 1, -1]])
    plain, noisy = (
        MassProperties(1.0, np.zeros(3), t).principal() for t in (tensor, tensor + noise)
    )
    np.testing.assert_allclose(noisy[0], plain[0], atol=1e-9)
    rebuilt = plain[1] @ np.diag(plain[0]) @ plain[1].T
    np.testing.assert_allclose(rebuilt, tensor, atol=1e-9)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(numbers, numbers, numbers), min_size=4, max_size=30, unique=True),
    st.floats(1e-4, 0.5),
    st.floats(1e-3, 10.0),
)
def test_moments_of_any_hull_and_of_its_walls_are_those_of_a_body(cloud, wall, scale):
    points = scale * np.array(cloud)
    if np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[2] < 1e-2 * scale:
        return
    hull = trimesh.convex.convex_hull(points)
    for found in (
        solid(hull.vertices, hull.faces, 1000.0),
        shell(hull.vertices, hull.faces, 1000.0, wall * scale),
    ):
        found.checked()
        moments, _ = found.principal()
        assert moments.max() <= (moments.sum() - moments.max()) * (1 + 1e-9)


@pytest.mark.parametrize(
    ("mass", "inertia", "message"),
    [
        (-1.0, np.eye(3), "is not positive"),
        (0.0, np.eye(3), "is not positive"),
        (np.nan, np.eye(3), "not a finite number"),
        (1.0, np.full((3, 3), np.nan), "not a finite number"),
        (1.0, np.diag([1.0, 1.0, -0.1]), "not positive"),
        (1.0, np.diag([1.0, 1.0, 2.1]), "more than the sum"),
        (1.0, np.eye(3) + np.triu(np.full((3, 3), 0.1), 1), "not symmetric"),
    ],
)
def test_what_no_body_can_have_is_said_with_its_place(mass, inertia, message):
    with pytest.raises(InputError, match=message) as caught:
        MassProperties(mass, np.zeros(3), inertia).checked("/World/Chair")
    assert caught.value.place == "/World/Chair"
    assert caught.value.remedy
