"""Surfels of a scan: one a voxel, each with a normal and the residual of its plane fit.

Whatever looks for planes counts surfels and not points, so that a wall that was scanned a hundred
times weighs as much as one that was scanned once. Normals are the least principal axis of the
points in the 27 voxels around; where a scan is sparse, of the nearest points (see `nearest`).
"""

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.vectors import unit
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.nearest import nearest_planes
from openrooms_usd.scan.points.principal import least_principal_axes, moments
from openrooms_usd.scan.points.thinning import thin

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

VOXEL_M: Final = 0.05
# Points are first downsampled to this part of a voxel.
_THINNING_VOXELS: Final = 0.5
# Least points of a plane fit; where there are fewer, the nearest points serve.
_MIN_POINTS: Final = 6
_WIDEST_VOXELS: Final = 4
# Neighbourhoods with less than this part of the usual number of points are outliers.
_STRAY_SHARE: Final = 0.2
# Edge of the cubes within which numbers of points are compared, metres.
_COMPARED_CUBE_M: Final = 0.4
# Points farther than this from the middle are of no room, metres.
_MAX_DISTANCE_M: Final = 60.0


@dataclass(frozen=True, eq=False)
class Surfels:
    """M surfels.

    Attributes:
        points: (M, 3) their centres, metres.
        normals: (M, 3) unit vectors; the sign is arbitrary.
        rough: (M,) root mean squared residual of the plane fit, metres.
        share: (M,) number of points, weighted by confidence, relative to the surfels around: low
            at the edges of a noisy wall, which is several voxels thick.
        label: (M,) NYU40 classes; None where the scan has none.
    """

    points: Array
    normals: Array
    rough: Array
    share: Array
    label: NDArray[np.int32] | None = None

    def __len__(self) -> int:
        return len(self.points)

    def take(self, rows: NDArray[Any]) -> "Surfels":
        """Some of the surfels, by row numbers or a mask."""
        label = None if self.label is None else self.label[rows]
        return Surfels(
            self.points[rows], self.normals[rows], self.rough[rows], self.share[rows], label
        )

    def moved(self, matrix: Array) -> "Surfels":
        """The surfels after a rigid motion (4, 4)."""
        turn = matrix[:3, :3]
        points = self.points @ turn.T + matrix[:3, 3]
        return Surfels(points, self.normals @ turn.T, self.rough, self.share, self.label)


def surfels(cloud: Cloud, voxel: float = VOXEL_M) -> Surfels:
    """The surfels of a scan.

    Args:
        cloud: Finite points near the origin, metres.
        voxel: Edge length, metres.

    Returns:
        One surfel for each occupied voxel with enough points around, in the order of the voxels.
        The scan's own normals are not used: they may be missing, or noisy.
    """
    near = np.abs(cloud.points - np.median(cloud.points, axis=0)).max(axis=1) < _MAX_DISTANCE_M
    bare = Cloud(cloud.points, label=cloud.label, confidence=cloud.confidence).take(near)
    fine = thin(bare, voxel * _THINNING_VOXELS)
    pieces = thin(fine, voxel)
    normals, rough, count = _planes(fine.points, pieces.points, voxel)
    usual, spread = float(np.median(count)), np.ones(len(pieces))
    lonely = np.flatnonzero(count < _MIN_POINTS)
    if len(lonely):
        found = nearest_planes(fine.points, pieces.points[lonely])
        rows = lonely[found.flat]
        normals[rows], rough[rows] = found.normals[found.flat], found.rough[found.flat]
        spread[rows] = found.spacing[found.flat] / voxel
        count[rows] = np.maximum(usual, _MIN_POINTS)
    kept = (count >= _MIN_POINTS) & (count >= _STRAY_SHARE * usual) & np.isfinite(rough)
    share = _shares(bare, pieces.points, voxel)
    flat = Surfels(pieces.points, normals, rough, share, pieces.label).take(kept)
    return _filled(flat, np.rint(spread[kept]).astype(int), voxel)


def _filled(pieces: Surfels, spread: Rows, voxel: float) -> Surfels:
    """Surfels of sparse places resampled on their planes at the fine spacing."""
    wide = np.clip(spread, 1, _WIDEST_VOXELS)
    parts = [pieces.take(wide == 1)]
    for size in range(2, _WIDEST_VOXELS + 1):
        some = pieces.take(wide == size)
        if len(some):
            across = unit(np.cross(some.normals, np.eye(3)[np.abs(some.normals).argmin(axis=1)]))
            along = np.cross(some.normals, across)
            for u, v in np.stack(np.meshgrid(*[np.arange(size)] * 2), -1).reshape(-1, 2):
                step = voxel * ((u - (size - 1) / 2.0) * across + (v - (size - 1) / 2.0) * along)
                parts.append(replace(some, points=some.points + step))
    return _joined(parts) if len(parts) > 1 else parts[0]


def _joined(parts: list[Surfels]) -> Surfels:
    names = ("points", "normals", "rough", "share")
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    labels = [part.label for part in parts if part.label is not None]
    return Surfels(**joined, label=np.concatenate(labels) if labels else None)


def _shares(cloud: Cloud, places: Array, voxel: float) -> Array:
    """(M,) confidence-weighted points a voxel, relative to the mean of its cube, at most 2."""
    origin = cloud.points.min(axis=0)
    mass = _counts(cloud.points - origin, places - origin, voxel, cloud.confidence)
    blocks = _counts(places - origin, places - origin, _COMPARED_CUBE_M, mass)
    pieces = _counts(places - origin, places - origin, _COMPARED_CUBE_M, None)
    return np.asarray(np.minimum(mass * pieces / np.maximum(blocks, 1e-9), 2.0))


def _counts(points: Array, places: Array, size: float, weight: NDArray[Any] | None) -> Array:
    """(M,) the number, or total weight, of the points in the cube of each place."""
    spans = np.floor(points.max(axis=0) / size).astype(np.int64) + 1
    strides = np.array([spans[1] * spans[2], spans[2], 1])
    cubes, cube = np.unique(np.floor(points / size).astype(np.int64) @ strides, return_inverse=True)
    totals = np.bincount(cube, weight).astype(np.float64)
    at = np.searchsorted(cubes, np.floor(places / size).astype(np.int64) @ strides)
    return np.asarray(totals[np.minimum(at, len(cubes) - 1)])


def _planes(points: Array, places: Array, voxel: float) -> tuple[Array, Array, Array]:
    """Normals (M, 3), residuals (M,) and point counts (M,) of plane fits to 27 voxels each."""
    origin = points.min(axis=0)
    points, places = points - origin, places - origin
    low = -2.0 * voxel
    spans = np.ceil((points.max(axis=0) - low) / voxel).astype(np.int64) + 2
    strides = np.array([spans[1] * spans[2], spans[2], 1])
    keys = np.floor((points - low) / voxel).astype(np.int64) @ strides
    cells, cell = np.unique(keys, return_inverse=True)
    sums = np.column_stack([np.bincount(cell, column) for column in moments(points)])
    asked, place = np.unique(
        np.floor((places - low) / voxel).astype(np.int64) @ strides, return_inverse=True
    )
    offsets = np.array(np.meshgrid(*[(-1, 0, 1)] * 3)).reshape(3, -1).T @ strides
    total = np.zeros((len(asked), sums.shape[1]))
    for offset in offsets:
        at = np.minimum(np.searchsorted(cells, asked + offset), len(cells) - 1)
        total += np.where((cells[at] == asked + offset)[:, None], sums[at], 0.0)
    normals, rough = least_principal_axes(total)
    return normals[place], rough[place], total[place, 0]
