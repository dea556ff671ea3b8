"""Lines of geometry, lines of photographs, and how far the ones are from the others.

Lines of geometry are where depth steps, surfaces bend, or a part ends. A line of a photograph is
one of its own only if it has about its direction.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.appearance.edges import BINS, photograph_edges
from openrooms_usd.appearance.motions import in_camera
from openrooms_usd.appearance.views import Geometry, Size
from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.geometry.pinhole import pixel_directions

_STEP_SHARE: Final = 0.04
_CREASE_DEG: Final = 30.0
_NEAREST_M: Final = 0.1
# Lines farther away than this say nothing, of the picture's width.
REACH_SHARE: Final = 0.08


@dataclass(frozen=True, eq=False)
class Lines:
    """Points on lines of geometry that one camera sees.

    Attributes:
        points: (N, 3) world, metres.
        across: (N, 2) unit, in the picture across the line.
        bins: (N,) which part of half a turn ``across`` is in.
    """

    points: Array
    across: Array
    bins: NDArray[np.int64]

    def thinned(self, count: int) -> "Lines":
        """At most about so many, evenly."""
        every = max(1, -(-len(self.points) // count))
        return Lines(self.points[::every], self.across[::every], self.bins[::every])


def geometry_lines(geometry: Geometry, K: Array, pose: Array, size: Size) -> Lines:
    """The lines of geometry that a camera sees.

    Args:
        geometry: The room.
        K: (3, 3) pixels.
        pose: (4, 4) world_from_camera.
        size: Width and height, pixels.
    """
    from scipy.ndimage import gaussian_filter

    seen = geometry(K, pose, size)
    rays = pixel_directions(K, *size)
    mask = np.zeros(seen.depth.shape)
    found, cells = [], []
    for axis in (0, 1):
        at = _borders(seen.depth, seen.normal, seen.part, axis)
        row, column = np.nonzero(at)
        beyond = (row + 1, column) if axis == 0 else (row, column + 1)
        # Between two pixels, on the nearer surface.
        between = 0.5 * (rays[row, column] + rays[beyond])
        here, there = seen.depth[row, column], seen.depth[beyond]
        near = np.where((here > 0) & ((here <= there) | (there <= 0)), here, there)
        found.append(near[:, None] * between @ pose[:3, :3].T + pose[:3, 3])
        cells.append(np.column_stack([row, column]))
        mask[row, column] = 1.0
        mask[beyond] = 1.0
    blurred = gaussian_filter(mask, 1.0)
    dy, dx = np.gradient(blurred)
    xx, yy, xy = (gaussian_filter(v, 2.0) for v in (dx * dx, dy * dy, dx * dy))
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    cell = np.concatenate(cells)
    chosen = angle[cell[:, 0], cell[:, 1]]
    across = np.column_stack([np.cos(chosen), np.sin(chosen)])
    # A slanted line has points of both axes; each axis keeps the lines that it crosses.
    own = np.repeat([False, True], [len(one) for one in cells])
    keep = np.where(own, np.abs(across[:, 0]) >= 0.5, np.abs(across[:, 1]) >= 0.5)
    bins = np.floor((chosen % np.pi) / np.pi * BINS).astype(np.int64) % BINS
    return Lines(np.concatenate(found)[keep], across[keep], bins[keep])


def _borders(depth: Array, normal: Array, part: NDArray[np.int64], axis: int) -> NDArray[np.bool_]:
    """(H, W) where a pixel and the next one along an axis are on both sides of a line."""
    near = np.where(depth > 0.0, 1.0 / np.maximum(depth, 1e-6), 0.0)
    before, after, beyond = (np.roll(near, by, axis) for by in (1, -1, -2))
    step = np.abs(after - near)
    # Along a plane 1 / depth is linear: only a step that is not its neighbours' is an edge.
    usual = np.maximum(np.abs(near - before), np.abs(beyond - after))
    jump = step - np.minimum(usual, step) > _STEP_SHARE * np.maximum(near, after)
    bend = (normal * np.roll(normal, -1, axis)).sum(axis=-1) < np.cos(np.radians(_CREASE_DEG))
    ends = part != np.roll(part, -1, axis)
    some = (near > 0.0) | (after > 0.0)
    solid = (near > 0.0) & (after > 0.0)
    inside = np.zeros(depth.shape, bool)
    inside[3:-3, 3:-3] = True
    return np.asarray(some & inside & (jump | (solid & bend) | ends))


@dataclass(frozen=True, eq=False)
class Drawing:
    """A photograph's lines, by direction.

    Attributes:
        K: (3, 3) pixels.
        pose: (4, 4) world_from_camera as it is said.
        distance: (bins, H, W) pixels to the nearest line of about that direction, at most `reach`.
        nearest: (bins, 2, H, W) its column and row.
    """

    K: Array
    pose: Array
    distance: NDArray[np.float32]
    nearest: NDArray[np.int16]

    @property
    def size(self) -> Size:
        """Width and height."""
        return self.distance.shape[2], self.distance.shape[1]

    def expected(self, sigma: float) -> Array:
        """(bins,) mean closeness of a point anywhere in the picture."""
        return np.asarray(closeness(self.distance, sigma).mean(axis=(1, 2)), dtype=np.float64)

    def cells(self, local: Array) -> tuple[Array, NDArray[np.int64], NDArray[np.bool_]]:
        """Where points are in the picture.

        Args:
            local: (N, 3) in the camera's frame.

        Returns:
            (N, 2) pixels, (N, 2) column and row, and (N,) whether it is inside.
        """
        front = local[:, 2] > _NEAREST_M
        z = np.where(front, local[:, 2], 1.0)
        pixel = (local[:, :2] / z[:, None]) * self.K[[0, 1], [0, 1]] + self.K[:2, 2]
        inside = front & (pixel >= 0).all(axis=1) & (pixel < self.size).all(axis=1)
        cell = np.where(inside[:, None], np.floor(pixel), 0).astype(np.int64)
        return pixel, cell, inside


def closeness(distance: NDArray[np.floating], sigma: float) -> NDArray[np.floating]:
    """1 on a line, near 0 some ``sigma`` pixels off it."""
    return np.asarray(np.exp(-0.5 * np.square(distance / sigma)))


def drawing(pixels: Bytes, K: Array, pose: Array) -> Drawing:
    """The lines of a photograph.

    Args:
        pixels: (H, W, 3) sRGB.
        K: (3, 3) pixels.
        pose: (4, 4) world_from_camera.
    """
    from scipy.ndimage import distance_transform_edt

    edges = photograph_edges(pixels)
    shape = edges.mask.shape
    reach = REACH_SHARE * shape[1]
    distance = np.full((BINS, *shape), reach, np.float32)
    nearest = np.zeros((BINS, 2, *shape), np.int16)
    for number in range(BINS):
        off = (edges.bins - number) % BINS
        alike = edges.mask & ((off <= 1) | (off == BINS - 1))
        if alike.any():
            far, place = distance_transform_edt(~alike, return_indices=True)
            distance[number] = np.minimum(far, reach)
            nearest[number] = place[::-1]
    return Drawing(K, pose, distance, nearest)


def agreement(
    drawings: Sequence[Drawing], lines: Sequence[Lines], poses: Sequence[Array], sigma: float
) -> Array:
    """(F,) how much nearer than by chance the geometry's lines are to each photograph's.

    Args:
        drawings: Of F photographs.
        lines: What their cameras see.
        poses: (4, 4) world_from_camera that are tried.
        sigma: Pixels.
    """
    scores = np.zeros(len(drawings))
    for index, (drawn, seen, pose) in enumerate(zip(drawings, lines, poses, strict=True)):
        if not len(seen.points):
            continue
        _, cell, inside = drawn.cells(in_camera(seen.points, pose))
        bins = seen.bins
        near = closeness(drawn.distance[bins, cell[:, 1], cell[:, 0]], sigma)
        above = near - drawn.expected(sigma)[bins]
        scores[index] = float((above * inside).sum() / len(seen.points))
    return scores


def distances(drawn: Drawing, lines: Lines, pose: Array) -> Array:
    """(N,) pixels from a photograph's lines of the points that a pose (4, 4) sees inside it."""
    _, cell, inside = drawn.cells(in_camera(lines.points, pose))
    column, row = cell[inside].T
    return np.asarray(drawn.distance[lines.bins[inside], row, column], dtype=np.float64)
