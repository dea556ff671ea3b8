"""Cameras as arrays, in the OpenCV frame: x right, y down, z forward.

Pinholes, panoramas, and parallel rays.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.geometry.vectors import unit


def intrinsics(fov_degrees: float, width: int, height: int) -> Array:
    """(3, 3) intrinsics in pixels of a centred camera with square pixels.

    Args:
        fov_degrees: Horizontal field of view.
        width: Pixels.
        height: Pixels; the centre of the top-left pixel is (0.5, 0.5).
    """
    focal = width / 2.0 / math.tan(math.radians(fov_degrees) / 2.0)
    return np.array([[focal, 0.0, width / 2.0], [0.0, focal, height / 2.0], [0.0, 0.0, 1.0]])


def pixel_directions(K: Array, width: int, height: int) -> Array:
    """(height, width, 3) directions through the pixels' centres, camera frame, z = 1.

    A point at planar depth d in a pixel is d times its direction.
    """
    x = (np.arange(width) + 0.5 - K[0, 2]) / K[0, 0]
    y = (np.arange(height) + 0.5 - K[1, 2]) / K[1, 1]
    return np.stack(np.broadcast_arrays(x[None, :], y[:, None], 1.0), axis=-1)


def parallel_origins(K: Array, width: int, height: int) -> Array:
    """(height, width, 3) where an orthographic picture's pixels are, camera frame, z = 0.

    Args:
        K: (3, 3) pixels per metre, and where the camera's axis is.
        width: Pixels.
        height: Pixels.
    """
    return pixel_directions(K, width, height) * (1.0, 1.0, 0.0)


def panorama_intrinsics(width: int, height: int) -> Array:
    """(3, 3) pixels per radian, and the middle, of a panorama that shows all directions."""
    fx, fy = width / (2.0 * math.pi), height / math.pi
    return np.array([[fx, 0.0, width / 2.0], [0.0, fy, height / 2.0], [0.0, 0.0, 1.0]])


def panorama_directions(K: Array, width: int, height: int) -> Array:
    """(height, width, 3) unit directions of an equirectangular picture's pixels, camera frame.

    Columns are angles to the right of the forward direction, rows angles below the horizon.

    Args:
        K: (3, 3) pixels per radian, and where the forward direction is.
        width: Pixels.
        height: Pixels.
    """
    right = ((np.arange(width) + 0.5 - K[0, 2]) / K[0, 0])[None, :]
    down = ((np.arange(height) + 0.5 - K[1, 2]) / K[1, 1])[:, None]
    level = np.cos(down)
    parts = np.broadcast_arrays(level * np.sin(right), np.sin(down), level * np.cos(right))
    return np.stack(parts, axis=-1)


def rotations(forwards: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> Array:
    """(C, 3, 3) upright rotations from the camera frame to the world.

    Args:
        forwards: (C, 3) viewing directions of any length.
        up: The world's up; where a camera looks along it, the picture's up is the world's +Y.
    """
    ahead = unit(np.asarray(forwards, dtype=np.float64).reshape(-1, 3))
    right = np.cross(ahead, np.asarray(up, dtype=np.float64))
    vertical = np.linalg.norm(right, axis=1) < 1e-6
    right[vertical] = np.cross(ahead[vertical], (0.0, 1.0, 0.0))
    right = unit(right)
    return np.stack([right, np.cross(ahead, right), ahead], axis=-1)


def look_at(eye: ArrayLike, target: ArrayLike) -> Array:
    """(4, 4) world_from_camera of an upright camera at ``eye`` that sees ``target`` in its middle.

    Raises:
        InputError: The two points coincide.
    """
    origin, aim = (np.asarray(point, dtype=np.float64) for point in (eye, target))
    if not np.linalg.norm(aim - origin) > 1e-9:
        raise InputError(
            "the camera's eye and target are the same point",
            remedy="move one of them: the direction of view is from the eye to the target",
        )
    return pose(rotations(aim - origin)[0], origin)
