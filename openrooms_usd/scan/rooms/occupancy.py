"""Grids of the plan: occupancy, and free space along the sensors' rays."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.scan.points.surfels import Surfels
from openrooms_usd.scan.rooms.directions import UPRIGHT_SINE

PIXEL_M: Final = 0.05
# Half the height of the slab at the sensors that is tested for occlusion, metres, and the part of
# it that must be filled.
_VIEW_HALF_HEIGHT_M: Final = 0.25
_BLOCKING_SHARE: Final = 0.5
_MOST_SENSORS: Final = 60
_MOST_SIGHTS: Final = 20_000
_RAYS_PER_TURN: Final = 720
_MAX_SIGHT_M: Final = 10.0


def disc(radius: int) -> Mask:
    """A disc as a structuring element."""
    x, y = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    return np.asarray(x * x + y * y <= radius * radius + 0.5)


def plan_map(plan: Array, low: Array, shape: tuple[int, ...], weight: Array | None = None) -> Array:
    """(X, Y) number, or total weight, of points (N, 2) a pixel; the grid begins at low (2,)."""
    pixel = np.floor((plan - low) / PIXEL_M).astype(int)
    within = ((pixel >= 0) & (pixel < shape)).all(axis=1)
    flat = np.ravel_multi_index(tuple(pixel[within].T), shape)
    weights = None if weight is None else weight[within]
    return np.bincount(flat, weights, int(np.prod(shape))).astype(np.float64).reshape(shape)


def at_sensor_height(pieces: Surfels, origin: float, low: Array, shape: tuple[int, ...]) -> Mask:
    """(X, Y) pixels with occluders at the height of the sensors."""
    from scipy import ndimage

    upright = np.abs(pieces.normals[:, 2]) < UPRIGHT_SINE
    facing = upright & (np.abs(pieces.points[:, 2] - origin) < _VIEW_HALF_HEIGHT_M)
    filled = plan_map(pieces.points[facing, :2], low, shape)
    across = ndimage.uniform_filter(filled, 3) * 9.0 / 1.5
    return np.asarray(
        (filled > 0) & (across > _BLOCKING_SHARE * 2.0 * _VIEW_HALF_HEIGHT_M / PIXEL_M)
    )


def free_space(barrier: Mask, sensor_origins: Array) -> Mask:
    """(X, Y) pixels on rays from sensors (pixels) up to a barrier; others do not count."""
    from scipy import ndimage

    some = sensor_origins[:: max(1, len(sensor_origins) // _MOST_SENSORS)]
    angles = np.linspace(0.0, 2.0 * np.pi, _RAYS_PER_TURN, endpoint=False)
    toward = np.column_stack([np.cos(angles), np.sin(angles)])
    reach = np.arange(0.0, _MAX_SIGHT_M / PIXEL_M, 0.7)
    solid = np.pad(ndimage.binary_dilation(barrier, disc(1)), 1)
    seen = np.zeros(solid.shape, bool)
    for origin in some:
        place = np.floor(origin + toward[:, None, :] * reach[None, :, None]).astype(int) + 1
        place = np.clip(place, 0, np.array(solid.shape) - 1)
        x, y = place[..., 0], place[..., 1]
        stopped = np.maximum.accumulate(solid[x, y], axis=1)
        kept = stopped[:, -1:] & ~stopped
        seen[x[kept], y[kept]] = True
    return np.asarray(ndimage.binary_closing(seen, disc(1))[1:-1, 1:-1])


def free_along_rays(plan: Array, sensor_origins: Array, low: Array, shape: tuple[int, ...]) -> Mask:
    """(X, Y) pixels on the segments between points (N, 2) and sensors (E, 2)."""
    some = plan[:: max(1, len(plan) // _MOST_SIGHTS)]
    seen = np.zeros(shape, bool)
    for origin in sensor_origins:
        longest = float(np.linalg.norm(some - origin, axis=1).max(initial=0.0))
        part = np.linspace(0.0, 1.0, int(longest / (0.7 * PIXEL_M)) + 2)[:, None, None]
        pixel = (
            np.floor((origin + part * (some - origin) - low) / PIXEL_M).astype(int).reshape(-1, 2)
        )
        pixel = pixel[((pixel >= 0) & (pixel < shape)).all(axis=1)]
        seen[tuple(pixel.T)] = True
    return seen
