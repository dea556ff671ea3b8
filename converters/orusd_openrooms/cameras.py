"""``cam.txt``, ``transform.dat`` and ``intrinsic.txt``: cameras in a world whose Y is up."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.arrays import Array

# From our world, Z up, to theirs, Y up: a quarter turn around X.
THEIRS_FROM_OURS: Final[Array] = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
# The released files have three decimals, with which view and up may miss a right angle by 1e-3;
# loaders refuse 2e-3.
_CAMERA_DECIMALS: Final = 6


def pose(world_from_camera: Array) -> Array:
    """Origin, target and up of a camera.

    Args:
        world_from_camera: (4, 4) from the OpenCV camera frame to our world, metres.

    Returns:
        (3, 3) rows in their world, metres: origin, origin + unit view direction, unit up.
    """
    turn = THEIRS_FROM_OURS @ world_from_camera[:3, :3]
    origin = THEIRS_FROM_OURS @ world_from_camera[:3, 3]
    view = turn[:, 2] / np.linalg.norm(turn[:, 2])
    up = -turn[:, 1]
    up = up - (up @ view) * view
    return np.stack([origin, origin + view, up / np.linalg.norm(up)])


def write_cameras(path: Path, poses: Sequence[Array]) -> None:
    """Write ``cam.txt``: their number, then three rows for each.

    Args:
        path: The file.
        poses: (3, 3) each, as `pose` gives them.

    Raises:
        OutputError: The file cannot be written.
    """
    rows = [row for each in poses for row in np.round(each, _CAMERA_DECIMALS) + 0.0]
    lines = [" ".join(f"{value:.{_CAMERA_DECIMALS}f}" for value in row) for row in rows]
    atomic.write_text(path, "\n".join([str(len(poses)), *lines]) + "\n")


def write_intrinsics(path: Path, K: Array) -> None:
    """Write the (3, 3) matrix as rows of text.

    Raises:
        OutputError: The file cannot be written.
    """
    lines = (" ".join(f"{value:.9g}" for value in row) for row in K)
    atomic.write_text(path, "\n".join(lines) + "\n")


def layout_transforms() -> list[Any]:
    """What ``transform.dat`` holds: how the layout came from our world into theirs.

    Further entries would be those of aligned CAD models; a render names none.
    """
    return [[("s", np.ones(3)), ("rot", THEIRS_FROM_OURS.copy()), ("t", np.zeros(3))]]
