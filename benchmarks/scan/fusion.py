"""Returns of many frames to one point for each cell of a grid."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from benchmarks.scan.rooms import Part
from openrooms_usd.arrays import Array, Ints
from openrooms_usd.scan.points.cloud import Cloud

# Bits of a cell's number along an axis, and of a part's.
_AXIS, _PART = 16, 14
# Cells with so many returns count as sure.
SURE: Final = 8.0
NEIGHBOURS: Final = 20


class Fused:
    """Sums over cells and parts, so that memory does not grow with frames.

    Args:
        voxel: The cells' edge, metres.
        parts: How many parts there are.
    """

    def __init__(self, voxel: float, parts: int) -> None:
        if parts >= 1 << _PART:
            raise ValueError(f"{parts} parts do not fit")
        self._voxel = voxel
        self._keys: list[Ints] = []
        self._sums: list[Array] = []

    def add(self, points: Array, part: Ints, back: Array) -> None:
        """Returns of one frame: places, parts and directions back to the camera."""
        cell = np.floor(points / self._voxel).astype(np.int64) + (1 << (_AXIS - 1))
        key = ((cell[:, 0] << _AXIS | cell[:, 1]) << _AXIS | cell[:, 2]) << _PART | part
        self._push(key, np.column_stack([np.ones(len(key)), points, back]))
        if len(self._keys) > 16:
            self._merge()

    def _push(self, key: Ints, values: Array) -> None:
        found, inverse = np.unique(key, return_inverse=True)
        sums = [np.bincount(inverse, column, len(found)) for column in values.T]
        self._keys.append(found)
        self._sums.append(np.stack(sums, axis=1))

    def _merge(self) -> None:
        keys, sums = np.concatenate(self._keys), np.concatenate(self._sums)
        self._keys, self._sums = [], []
        self._push(keys, sums)

    def cells(self) -> tuple[Array, Ints, Array, Array]:
        """One row for each cell: mean place, most frequent part, mean direction back, returns."""
        if not self._keys:
            return np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)
        self._merge()
        keys, sums = self._keys[0], self._sums[0]
        cell, first, inverse = np.unique(keys >> _PART, return_index=True, return_inverse=True)
        total = np.stack([np.bincount(inverse, c, len(cell)) for c in sums.T], axis=1)
        # Within a cell by falling count: its first row is then the most frequent part.
        order = np.lexsort((-sums[:, 0], inverse))
        part = (keys & ((1 << _PART) - 1))[order[first]]
        count = total[:, 0]
        return total[:, 1:4] / count[:, None], part, total[:, 4:7] / count[:, None], count


def fuse(fused: Fused, parts: Sequence[Part], sensor_origins: Array, fewest: int = 1) -> Cloud:
    """The cloud of all returns, its normals by planes through neighbours.

    Args:
        fused: The returns.
        parts: What they are of.
        sensor_origins: (V, 3) where the cameras stood.
        fewest: Cells with fewer returns are dropped.
    """
    cells = fused.cells()
    points, part, back, count = (values[cells[3] >= fewest] for values in cells)
    label = np.array([p.label for p in parts], dtype=np.int32)[part]
    instance = np.array([p.instance for p in parts], dtype=np.int32)[part]
    normals = fitted_normals(points, back) if len(points) > NEIGHBOURS else back
    return Cloud(
        points,
        normals=normals.astype(np.float32),
        label=label,
        instance=instance,
        confidence=(count / (count + SURE)).astype(np.float32),
        sensor_origins=sensor_origins,
    )


def fitted_normals(points: Array, back: Array) -> Array:
    """(N, 3) normals of planes through neighbours, to the side of the camera."""
    from scipy.spatial import cKDTree

    tree, normals = cKDTree(points), np.empty_like(points)
    for rows in np.array_split(np.arange(len(points)), len(points) // 100_000 + 1):
        near = points[tree.query(points[rows], k=NEIGHBOURS)[1]]
        axes = np.moveaxis(near - near.mean(axis=1, keepdims=True), 2, 0).copy()
        spread = np.stack([np.einsum("nk,ink->ni", axis, axes) for axis in axes], axis=2)
        normals[rows] = np.linalg.eigh(spread)[1][:, :, 0]
    facing = np.einsum("ij,ij->i", normals, back) < 0
    normals[facing] *= -1
    return normals
