"""Cameras as Hypersim has them: x right, y up, z backward; one unit of its assets is one metre.

Its own frames are described in the README of ml-hypersim; the matrices of a scene's lens in its
``contrib/mikeroberts3000``.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.rendering.reading import RenderedView

OPENGL: Final = np.diag([1.0, -1.0, -1.0])
"""OpenCV's axes in those of Hypersim's cameras."""

NEAR: Final = 1.0
FAR: Final = 1000.0


def orientations(views: Sequence[RenderedView]) -> Array:
    """(N, 3, 3) from each camera to the world."""
    return np.stack([view.world_from_camera[:3, :3] @ OPENGL for view in views])


def positions(views: Sequence[RenderedView]) -> Array:
    """(N, 3) of the cameras, metres."""
    return np.stack([view.world_from_camera[:3, 3] for view in views])


def projection(view: RenderedView) -> Array:
    """(4, 4) from the camera's frame to clip space, as OpenGL has it.

    Clip space divided by its last component is -1 to 1 over the picture, y upward; the centre of
    the top-left pixel is (-1 + 1 / width, 1 - 1 / height).
    """
    K, (width, height) = view.K, (view.width, view.height)
    found = np.zeros((4, 4))
    found[0] = [2.0 * K[0, 0] / width, 0.0, 1.0 - 2.0 * K[0, 2] / width, 0.0]
    found[1] = [0.0, 2.0 * K[1, 1] / height, 2.0 * K[1, 2] / height - 1.0, 0.0]
    found[2, 2:] = -(FAR + NEAR) / (FAR - NEAR), -2.0 * FAR * NEAR / (FAR - NEAR)
    found[3, 2] = -1.0
    return found


def rays(view: RenderedView) -> Array:
    """(3, 3) from (u, v, 1), -1 to 1 over the picture and v upward, to rays one unit deep."""
    K, (width, height) = view.K, (view.width, view.height)
    across, up = width / (2.0 * K[0, 0]), height / (2.0 * K[1, 1])
    return np.array(
        [
            [across, 0.0, across * (1.0 - 2.0 * K[0, 2] / width)],
            [0.0, up, up * (2.0 * K[1, 2] / height - 1.0)],
            [0.0, 0.0, -1.0],
        ]
    )
