"""Pinholes by hand-computed cases and identities."""

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.geometry.pinhole import intrinsics, look_at, pixel_directions, rotations
from openrooms_usd.geometry.rotations import is_rotation


def test_the_field_of_view_spans_the_picture() -> None:
    K = intrinsics(90.0, 200, 100)
    np.testing.assert_allclose(K, [[100, 0, 100], [0, 100, 50], [0, 0, 1]])
    rays = pixel_directions(K, 200, 100)
    assert rays.shape == (100, 200, 3)
    np.testing.assert_allclose(rays[0, 0], [-0.995, -0.495, 1.0])
    np.testing.assert_allclose(rays[-1, -1], [0.995, 0.495, 1.0])
    back = rays @ K.T  # every direction comes back to its own pixel's centre
    np.testing.assert_allclose(back[7, 31, :2], [31.5, 7.5])


def test_look_at_has_the_named_axes() -> None:
    np.testing.assert_allclose(
        look_at((1, 2, 3), (1, 5, 3)),
        [[1, 0, 0, 1], [0, 0, 1, 2], [0, -1, 0, 3], [0, 0, 0, 1]],
        atol=1e-12,
    )
    rng = np.random.default_rng(0)
    for R in rotations(rng.normal(size=(20, 3))):
        assert is_rotation(R, 1e-9)
        assert abs(R[2, 0]) < 1e-12  # the picture's horizon is level
        assert R[2, 1] <= 0  # and its up is up


@pytest.mark.parametrize("z", [-1.0, 1.0])
def test_straight_up_and_down_are_views_too(z: float) -> None:
    R = rotations([[0.0, 0.0, z]])[0]
    assert is_rotation(R, 1e-9)
    np.testing.assert_allclose(R[:, 2], [0, 0, z])


def test_nowhere_to_look_is_refused() -> None:
    with pytest.raises(InputError, match="same point"):
        look_at((1, 2, 3), (1, 2, 3))
