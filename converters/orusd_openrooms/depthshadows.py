"""Shadows that the depth of a picture alone tells, as IndoorLightEditing prepares them.

What a picture shows is taken for a sheet: its points joined to triangles where they are near each
other. From points of the sheet rays go to points of the light. A pixel holds the share that
arrives, and -1 where there is no sheet: loaders learn there that nothing is known.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.raycast import RayCaster
from orusd_openrooms.records import Light

Array = NDArray[np.float64]
Bits = NDArray[np.bool_]

# Points farther apart are not joined, of a picture whose mean depth is 3 m; of nearer ones too.
_JOINED_M: Final = 0.12
_USUAL_DEPTH_M: Final = 3.0
_LEAST_DEPTH_M: Final = 1.0
_SIDE_SAMPLES: Final = 4  # of a pixel, along a side
# Shadow rays begin and end this much before what they lead to.
_CLEARANCE_M: Final = 1e-3


def depth_shadow(light: Light, camera: Array, points: Array, K: Array, mask: Bits) -> Array:
    """The share of a light that reaches each pixel past all that the picture shows.

    Args:
        light: A lamp, whose box shines on all sides, or an opening.
        camera: (4, 4) from the world to the camera's right, up, backward.
        points: (rows, columns, 3) in that frame, metres; the origin where there is no surface.
        K: (3, 3) intrinsics for pictures of this size.
        mask: (rows, columns) where the picture shows the light itself, which casts no shadow.

    Returns:
        (rows, columns) -1 to 1: the mean over the pixel, in which what meets nothing counts -1.
    """
    rows, columns = mask.shape
    sheet = _sheet(points, mask)
    rng = np.random.default_rng(light.number)
    total = np.zeros(rows * columns)
    for part in range(_SIDE_SAMPLES**2):
        jitter = np.array(divmod(part, _SIDE_SAMPLES)) + rng.random((rows * columns, 2))
        ways = _rays(K, rows, columns, jitter / _SIDE_SAMPLES)
        found = sheet.first_hit(np.zeros(3), ways)
        total += np.where(found.hit, 0.0, -1.0)
        ways = ways[found.hit] / np.linalg.norm(ways[found.hit], axis=1, keepdims=True)
        places = ways * found.distance[found.hit, None]
        normals = sheet.normals[found.triangle[found.hit]]
        facing = normals * -np.sign((normals * ways).sum(axis=1, keepdims=True))
        path = _places(light, camera, rng.random((len(places), 3))) - places
        length = np.linalg.norm(path, axis=1)
        lit = (path * facing).sum(axis=1) >= 0.0
        begin = places + path * (_CLEARANCE_M / np.maximum(length, _CLEARANCE_M))[:, None]
        lit[lit] = ~sheet.occluded(begin[lit], path[lit], length[lit] - 2.0 * _CLEARANCE_M)
        total[found.hit] += lit
    share = (total / _SIDE_SAMPLES**2).reshape(rows, columns)
    # What shows a window is one, not a surface; so it is known.
    return np.minimum(share + mask, 1.0) if light.is_window else share


def _sheet(points: Array, mask: Bits) -> RayCaster:
    """The triangles between near points: two of each square, by the diagonal that fits."""
    # A pixel may hold any number.
    points = np.where(np.isfinite(points).all(axis=-1, keepdims=True), points, 0.0)
    depth = -points[..., 2]
    joined = _JOINED_M * max(float(depth.mean()), _LEAST_DEPTH_M) / _USUAL_DEPTH_M
    known = (depth > 0.0) & ~mask
    numbers = np.arange(mask.size).reshape(mask.shape)
    corners = [numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, :-1], numbers[1:, 1:]]
    flat = points.reshape(-1, 3)

    def near(a: int, b: int) -> Bits:
        limit = joined * (np.sqrt(2.0) if a + b == 3 else 1.0)
        return np.asarray(np.linalg.norm(flat[corners[a]] - flat[corners[b]], axis=-1) < limit)

    falling, rising = near(0, 3), near(1, 2) & ~near(0, 3)
    choices = {(0, 3, 1): falling, (0, 2, 3): falling, (0, 2, 1): rising, (2, 3, 1): rising}
    found = []
    for triangle, diagonal in choices.items():
        kept = diagonal.copy()
        for a, b in zip(triangle, (*triangle[1:], triangle[0]), strict=True):
            kept &= near(a, b) & known.ravel()[corners[a]]
        found.append(np.stack([corners[corner][kept] for corner in triangle], axis=-1))
    return RayCaster(flat, np.concatenate(found))


def _rays(K: Array, rows: int, columns: int, jitter: Array) -> Array:
    """(rows * columns, 3) right, up, backward through a place of each pixel."""
    y, x = np.divmod(np.arange(rows * columns), columns)
    pixels = np.stack([x + jitter[:, 1], y + jitter[:, 0], np.ones(len(x))], axis=-1)
    return np.asarray(pixels @ np.linalg.inv(K).T * [1.0, -1.0, -1.0])


def _places(light: Light, camera: Array, draws: Array) -> Array:
    """(N, 3) points of an opening's rectangle, or of the faces of a lamp's box, by their areas."""
    size = light.size
    areas = np.array([size[1] * size[2], size[2] * size[0], size[0] * size[1]])
    if light.is_window or not areas.any():
        areas = (size == size.min()) & (np.arange(3) == np.argmin(size))
    ends = np.cumsum(np.repeat(areas / areas.sum(), 2))
    face = np.minimum(np.searchsorted(ends, draws[:, 0], side="right"), 5)
    local = np.empty_like(draws)
    axis = face // 2
    rows = np.arange(len(draws))
    local[rows, (axis + 1) % 3], local[rows, (axis + 2) % 3] = draws[:, 1] - 0.5, draws[:, 2] - 0.5
    local[rows, axis] = face % 2 - 0.5
    world = light.center + (local * size) @ light.axes.T
    return np.asarray(world @ camera[:3, :3].T + camera[:3, 3])
