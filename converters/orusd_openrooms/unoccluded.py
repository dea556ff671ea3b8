"""The light that the fit of an opening would give if nothing stood in its way."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from orusd_openrooms.lights import spread
from orusd_openrooms.records import Light, Lobe

Array = NDArray[np.float64]

# Sharper lobes are integrated over their own directions, others over the rectangle.
_SHARP_LOBE: Final = 8.0
_SIDE_POINTS: Final = 12  # points along a side of the rectangle
_SPHERE_DIRECTIONS: Final = 256


def approximate(
    light: Light, camera: Array, points: NDArray[np.float32], normals: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Irradiance by the lobes of an opening through its rectangle, without occlusion.

    Args:
        light: An opening.
        camera: (4, 4) from the world to the camera's right, up, backward.
        points: (rows, columns, 3) in that frame, metres; the origin where there is no surface.
        normals: (rows, columns, 3) in that frame; the length does not matter, 0 is no surface.

    Returns:
        (rows, columns, 3) lux.
    """
    flat = points.reshape(-1, 3).astype(np.float64)
    lengths = np.linalg.norm(normals, axis=-1, keepdims=True)
    facing = (normals / np.maximum(lengths, 1e-6)).reshape(-1, 3).astype(np.float64)
    flat = (flat - camera[:3, 3]) @ camera[:3, :3]
    facing = facing @ camera[:3, :3]
    result = np.zeros_like(flat)
    for lobe in light.lobes.values() if light.on else ():
        through = _along_lobe if lobe.sharpness > _SHARP_LOBE else _over_rectangle
        result += through(light, lobe, flat, facing)[:, None] * lobe.intensity
    return result.reshape(points.shape).astype(np.float32)


def _rectangle(light: Light) -> tuple[Array, Array, Array]:
    """Two half edges, and the normal: the box's shortest axis."""
    normal, *edges = np.argsort(light.size)
    first, second = (0.5 * light.size[i] * light.axes[:, i] for i in edges)
    return first, second, light.axes[:, normal]


def _over_rectangle(light: Light, lobe: Lobe, points: Array, normals: Array) -> Array:
    """The integral over the rectangle by the midpoints of its parts."""
    first, second, normal = _rectangle(light)
    places = (np.arange(_SIDE_POINTS) + 0.5) / _SIDE_POINTS * 2.0 - 1.0
    area = 4.0 * np.linalg.norm(first) * np.linalg.norm(second) / _SIDE_POINTS**2
    total = np.zeros(len(points))
    for u in places:
        for v in places:
            way = light.center + u * first + v * second - points
            square = np.maximum((way**2).sum(axis=1), 1e-12)
            way = way / np.sqrt(square)[:, None]
            light_in = np.exp(lobe.sharpness * (way @ lobe.axis - 1.0))
            total += (
                light_in
                * np.maximum((way * normals).sum(axis=1), 0.0)
                * np.abs(way @ normal)
                / square
            )
    return total * area


def _along_lobe(light: Light, lobe: Lobe, points: Array, normals: Array) -> Array:
    """The integral over the lobe's directions, spread evenly by their weight."""
    first, second, normal = _rectangle(light)
    total = np.zeros(len(points))
    for way in _directions(lobe):
        slope = way @ normal
        if abs(slope) < 1e-9:
            continue
        distance = ((light.center - points) @ normal) / slope
        offset = points + distance[:, None] * way - light.center
        inside = (distance > 0) & (np.abs(offset @ first) <= first @ first)
        inside &= np.abs(offset @ second) <= second @ second
        total += inside * np.maximum(normals @ way, 0.0)
    return total * spread(lobe.sharpness) / _SPHERE_DIRECTIONS


def _directions(lobe: Lobe) -> Array:
    """(N, 3) unit vectors, as dense as the lobe is bright: a spiral by the golden angle."""
    share = (np.arange(_SPHERE_DIRECTIONS) + 0.5) / _SPHERE_DIRECTIONS
    cosine = 1.0 + np.log1p(share * np.expm1(-2.0 * lobe.sharpness)) / lobe.sharpness
    sine = np.sqrt(np.maximum(0.0, 1.0 - cosine**2))
    turn = np.arange(_SPHERE_DIRECTIONS) * np.pi * (3.0 - np.sqrt(5.0))
    side = np.cross(lobe.axis, np.eye(3)[np.argmin(np.abs(lobe.axis))])
    side = side / np.linalg.norm(side)
    other = np.cross(lobe.axis, side)
    ring = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other
    result: Array = cosine[:, None] * lobe.axis + sine[:, None] * ring
    return result
