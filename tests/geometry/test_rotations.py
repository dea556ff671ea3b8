"""Rotations and vectors by identities and another implementation (scipy's)."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.geometry import rotations
from openrooms_usd.geometry.rotations import (
    about_point,
    in_plan,
    inverse,
    is_rotation,
    nearest_rotation,
    pose,
)
from openrooms_usd.geometry.vectors import UP, unit

R = Rotation.from_euler("xyz", (0.3, -1.1, 2.0)).as_matrix()


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize("angle", [-2.5, -0.1, 0.0, 0.4, 3.0])
def test_a_turn_about_an_axis_is_that_of_another_library(axis: str, angle: float) -> None:
    found = getattr(rotations, f"about_{axis}")(angle)
    np.testing.assert_allclose(found, Rotation.from_euler(axis, angle).as_matrix(), atol=1e-15)


def test_turns_of_the_plan_are_those_about_the_vertical_one_by_one_or_together() -> None:
    angles = np.array([[0.2, -1.0, 3.0], [0.0, 5.0, -0.7]])
    found = in_plan(angles)
    assert found.shape == (2, 3, 2, 2)
    for index in np.ndindex(angles.shape):
        np.testing.assert_array_equal(found[index], rotations.about_z(angles[index])[:2, :2])
    # From X towards Y.
    np.testing.assert_allclose(in_plan(np.pi / 2) @ [1.0, 0.0], [0.0, 1.0], atol=1e-15)


def test_a_rigid_pose_is_undone_by_its_inverse_and_one_about_a_point_keeps_it() -> None:
    point = np.array([3.0, -1.0, 0.5])
    np.testing.assert_allclose(inverse(pose(R, point)) @ pose(R, point), np.eye(4), atol=1e-15)
    np.testing.assert_allclose(pose(R, point) @ [0, 0, 0, 1], [*point, 1.0])
    np.testing.assert_allclose(about_point(R, point) @ [*point, 1.0], [*point, 1.0])
    np.testing.assert_array_equal(about_point(R, point)[:3, :3], R)


def test_only_proper_rotations_pass() -> None:
    assert is_rotation(R)
    assert not is_rotation(1.01 * R)
    assert not is_rotation(R @ np.diag([1, 1, -1]))
    assert not is_rotation(np.full((3, 3), np.nan))
    sheared = R + np.array([[0, 0.1, 0], [0, 0, 0], [0, 0, 0]])
    assert not is_rotation(sheared)
    np.testing.assert_allclose(nearest_rotation(3.0 * R), R, atol=1e-12)
    assert is_rotation(nearest_rotation(sheared), 1e-12)


def test_vectors_of_length_zero_stay_or_become_what_was_asked_for() -> None:
    vectors = np.array([[[3.0, 0.0, -4.0], [0.0, 0.0, 0.0]]])
    np.testing.assert_allclose(unit(vectors), [[[0.6, 0.0, -0.8], [0.0, 0.0, 0.0]]])
    np.testing.assert_allclose(unit(vectors, UP), [[[0.6, 0.0, -0.8], [0.0, 0.0, 1.0]]])
    np.testing.assert_allclose(unit(np.array([0.0, 2.0])), [0.0, 1.0])
