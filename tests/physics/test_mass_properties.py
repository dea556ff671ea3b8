"""What is done with masses: frames, sums, scales, principal axes, and what no body can have."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from openrooms_usd.errors import InputError
from openrooms_usd.physics.inertia import shell, solid
from openrooms_usd.physics.mass import MassProperties, combined

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
        with pytest.raises(InputError, match="a mass of"):
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
