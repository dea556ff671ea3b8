"""Pieces of parts that light is reflected by: which one a point belongs to."""

from typing import Final

import numpy as np
from scipy.spatial import KDTree

from openrooms_usd.arrays import Array
from openrooms_usd.arrays import Ints as Rows

# Side of elements, metres: at most, at least, and by the length of a part.
_CELL_M: Final = 0.3
_LEAST_CELL_M: Final = 0.06
_PIECES: Final = 5
# Cells of an axis and directions that an element's key tells apart.
_CELLS: Final = 1 << 11
_FACES: Final = 8
# Cells between parts, when the nearest element is looked for.
_APART: Final = 1e4


class Elements:
    """Cuts parts into cubes, by the side that surfaces face.

    Args:
        part_of: (M,) the part of each triangle.
        corners: (M, 3, 3) world, metres.
    """

    def __init__(self, part_of: Rows, corners: Array) -> None:
        self._cell = _cells(part_of, corners)
        self._lower = corners.reshape(-1, 3).min(axis=0) if len(corners) else np.zeros(3)

    def key(self, part: Rows, position: Array, normal: Array) -> Rows:
        """(N,) of points of parts, with their unit normals."""
        cell = np.floor((position - self._lower) / self._cell[part, None]).astype(np.int64) + 1
        cell = np.clip(cell, 0, _CELLS - 1)
        axis = np.abs(normal).argmax(axis=1)
        sign = np.take_along_axis(normal, axis[:, None], 1)[:, 0] > 0.0
        key = part
        for number, size in ((cell[:, 0], _CELLS), (cell[:, 1], _CELLS), (cell[:, 2], _CELLS)):
            key = key * size + number
        return np.asarray(key * _FACES + 2 * axis + sign)


class Lookup:
    """The row of each element by its key; what is unknown is the nearest of its part."""

    def __init__(self, keys: Rows) -> None:
        self._keys = keys
        self.part, place = opened(keys)
        self._tree = KDTree(np.column_stack([place, _APART * self.part]))

    def __call__(self, keys: Rows) -> Rows:
        """(N,) rows of keys."""
        row = np.asarray(np.searchsorted(self._keys, keys).clip(0, len(self._keys) - 1))
        strange = np.flatnonzero(self._keys[row] != keys)
        if len(strange):
            unique, inverse = np.unique(keys[strange], return_inverse=True)
            part, place = opened(unique)
            near = np.asarray(self._tree.query(np.column_stack([place, _APART * part]))[1])
            row[strange] = near[inverse]
        return row


def opened(keys: Rows) -> tuple[Rows, Array]:
    """The part and the place in cells of keys, with the side that they face as a fourth."""
    rest, face = np.divmod(keys, _FACES)
    rest, z = np.divmod(rest, _CELLS)
    rest, y = np.divmod(rest, _CELLS)
    part, x = np.divmod(rest, _CELLS)
    sides = np.zeros((len(keys), 3))
    sides[np.arange(len(keys)), face // 2] = 2.0 * (face % 2) - 1.0
    return part, np.column_stack([x, y, z, sides]).astype(float)


def _cells(part_of: Rows, corners: Array) -> Array:
    """(P,) side of the cubes that parts are cut into, metres: fewer than a part is long."""
    count = int(part_of.max(initial=0)) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for corner in range(3):
        np.minimum.at(low, part_of, corners[:, corner])
        np.maximum.at(high, part_of, corners[:, corner])
    length = np.nan_to_num(np.where(high >= low, high - low, 0.0)).max(axis=1)
    return np.asarray(np.clip(length / _PIECES, _LEAST_CELL_M, _CELL_M))
