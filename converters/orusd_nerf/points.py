"""Points of surfaces, and which views see each: what photogrammetry would have to find.

They are the exact first hits of pixels on a regular grid of every view. A view sees a point that it
has in front of it and within its picture, where its own depth is that of the point.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.rendering.exr import Pixels
from orusd_nerf.cameras import Array, Camera

# Of one view, and of all.
_POINTS_A_VIEW: Final = 2048
_MOST_POINTS: Final = 100_000
# Depths that differ by less, relatively, are of the same surface: the pixel's centre lies beside.
_SAME_SURFACE_SHARE: Final = 0.01
# Without a picture.
_GREY: Final = 128


@dataclass(frozen=True, eq=False)
class Points:
    """Points of surfaces.

    Attributes:
        positions: (N, 3) metres, in the world.
        colors: (N, 3) as the view that they are taken from shows them.
    """

    positions: Array
    colors: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.positions)


@dataclass(frozen=True, eq=False)
class Sightings:
    """What one view sees of the points.

    Attributes:
        points: (M,) their indices, ascending.
        pixels: (M, 2) where they lie in the picture.
    """

    points: NDArray[np.int64]
    pixels: Array


NOTHING: Final = Sightings(np.empty(0, np.int64), np.empty((0, 2)))


def sample(camera: Camera, depth: Pixels, image: NDArray[np.uint8] | None, views: int) -> Points:
    """Points on a regular grid of a view's pixels.

    Args:
        camera: The view's.
        depth: (height, width, 1) planar, metres; 0 where nothing is.
        image: (height, width, 3) its colours, if it has any.
        views: How many views there are: together they have no more than a scene may have.
    """
    lens = camera.lens
    most = max(1, min(_POINTS_A_VIEW, _MOST_POINTS // views))
    step = max(1, math.ceil(math.sqrt(lens.width * lens.height / most)))
    rows, columns = np.meshgrid(
        np.arange(step // 2, lens.height, step),
        np.arange(step // 2, lens.width, step),
        indexing="ij",
    )
    far = depth[rows, columns, 0].astype(np.float64)
    there = np.isfinite(far) & (far > 0.0)
    rows, columns, far = rows[there], columns[there], far[there]
    seen = pixel_directions(camera.K, lens.width, lens.height)[rows, columns] * far[:, None]
    M = camera.world_from_camera
    colors = np.full((len(far), 3), _GREY, np.uint8) if image is None else image[rows, columns]
    return Points(seen @ M[:3, :3].T + M[:3, 3], colors)


def joined(parts: Sequence[Points]) -> Points:
    """All points of several views."""
    return Points(
        np.concatenate([np.empty((0, 3)), *(part.positions for part in parts)]),
        np.concatenate([np.empty((0, 3), np.uint8), *(part.colors for part in parts)]),
    )


def sightings(camera: Camera, depth: Pixels, points: Points) -> Sightings:
    """Which of the points a view sees, and where.

    Args:
        camera: The view's.
        depth: (height, width, 1) planar, metres; 0 where nothing is.
        points: Those of all views.
    """
    pixels, far = camera.project(points.positions)
    size = np.array([camera.lens.width, camera.lens.height])
    inside = np.flatnonzero((far > 0.0) & ((pixels >= 0.0) & (pixels < size)).all(axis=1))
    columns, rows = np.floor(pixels[inside]).astype(np.int64).T
    surface = depth[rows, columns, 0].astype(np.float64)
    same = np.abs(surface - far[inside]) <= _SAME_SURFACE_SHARE * far[inside]
    return Sightings(inside[same], pixels[inside[same]])
