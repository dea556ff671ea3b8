"""Rigid poses by position and unit quaternion (x, y, z, w), the order of robots' files."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from openrooms_usd.arrays import Array


def quaternion(R: Array) -> Array:
    """(4,) the quaternion x, y, z, w of a (3, 3) rotation, w not negative."""
    return np.asarray(Rotation.from_matrix(R).as_quat(canonical=True))


def pose_of(position: Sequence[float] | Array, q: Sequence[float] | Array) -> Array:
    """(4, 4) of a position and a quaternion x, y, z, w of any length."""
    M = np.eye(4)
    M[:3, :3] = Rotation.from_quat(q).as_matrix()
    M[:3, 3] = position
    return M
