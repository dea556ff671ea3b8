"""Questions to a floor polygon: what lies inside, and where its centre is."""

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Mask


def inside(polygon: ArrayLike, points: ArrayLike) -> Mask:
    """(N,) whether points lie inside a simple polygon, by the even-odd rule.

    Args:
        polygon: (P, 2) corners, either way round.
        points: (N, 2).
    """
    corners = np.asarray(polygon, dtype=np.float64)
    x, y = np.asarray(points, dtype=np.float64).reshape(-1, 2).T
    (x0, y0), (x1, y1) = corners.T, np.roll(corners, -1, axis=0).T
    crosses = (y0 > y[:, None]) != (y1 > y[:, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        meets = x0 + (y[:, None] - y0) * (x1 - x0) / (y1 - y0)
    return np.asarray((crosses & (x[:, None] < meets)).sum(axis=1) % 2 == 1)


def wall_distance(polygon: ArrayLike, points: ArrayLike) -> Array:
    """(N,) distance of points to the nearest side.

    Args:
        polygon: (P, 2) corners.
        points: (N, 2).
    """
    corners = np.asarray(polygon, dtype=np.float64)
    sides = np.roll(corners, -1, axis=0) - corners
    away = np.asarray(points, dtype=np.float64).reshape(-1, 1, 2) - corners
    squared = np.maximum((sides**2).sum(axis=1), 1e-18)
    along = np.clip((away * sides).sum(axis=2) / squared, 0.0, 1.0)
    return np.asarray(np.linalg.norm(away - along[..., None] * sides, axis=2).min(axis=1))


def room_centre(polygon: ArrayLike) -> Array:
    """(2,) the centroid; where it is outside or at a wall, the inner point farthest from walls.

    Args:
        polygon: (P, 2) corners of a simple polygon, either way round.
    """
    corners = np.asarray(polygon, dtype=np.float64)
    centroid = _centroid(corners)
    low, high = corners.min(axis=0), corners.max(axis=0)
    axes = [np.linspace(a, b, 34)[1:-1] for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    grid = grid[inside(corners, grid)]
    if not len(grid):
        return centroid
    room = wall_distance(corners, grid)
    central = inside(corners, centroid)[0]
    if central and wall_distance(corners, centroid)[0] >= 0.5 * room.max():
        return centroid
    return np.asarray(grid[room.argmax()])


def _centroid(corners: Array) -> Array:
    # About the mean of the corners: shoelace terms far from the origin would cancel.
    mean = corners.mean(axis=0)
    here = corners - mean
    after = np.roll(here, -1, axis=0)
    terms = here[:, 0] * after[:, 1] - after[:, 0] * here[:, 1]
    area = terms.sum()
    if area == 0.0:
        return np.asarray(mean)
    return np.asarray(mean + ((here + after) * terms[:, None]).sum(axis=0) / (3.0 * area))
