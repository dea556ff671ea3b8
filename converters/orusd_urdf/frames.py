"""Frames and numbers as the formats write them."""

import numpy as np

from openrooms_usd.arrays import Array


def rpy(turn: Array) -> Array:
    """(3,) roll, pitch, yaw of a rotation: about the fixed X, then Y, then Z, radians."""
    level = float(np.hypot(turn[0, 0], turn[1, 0]))
    pitch = np.arctan2(-turn[2, 0], level)
    if level > 1e-9:
        roll, yaw = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
    else:
        # Straight up or down, only the sum or the difference of roll and yaw has a meaning.
        roll, yaw = np.arctan2(-turn[1, 2], turn[1, 1]), 0.0
    return np.array([roll, pitch, yaw])


def relative(parent: Array, child: Array) -> Array:
    """(4, 4) parent_from_child of two rigid frames in a common one."""
    result = np.eye(4)
    result[:3, :3] = parent[:3, :3].T @ child[:3, :3]
    result[:3, 3] = parent[:3, :3].T @ (child[:3, 3] - parent[:3, 3])
    return result


def text(values: object) -> str:
    """Numbers for an attribute: the shortest that are exact, and never minus nothing."""
    numbers = np.asarray(values, dtype=np.float64).ravel() + 0.0
    return " ".join(repr(value).removesuffix(".0") for value in numbers.tolist())


def place(values: object) -> str:
    """Lengths and angles for an attribute, to a millionth of a micrometre."""
    return text(np.round(np.asarray(values, dtype=np.float64), 12))
