"""Which points of a cloud lie above a rectangle of the plan, without looking at all of them."""

from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Ints

Rows = NDArray[np.intp]

_CELL_M: Final = 0.25


class PlanIndex:
    """Points sorted once by the cells of their plan.

    Attributes:
        points: (N, 3) finite, metres.
    """

    def __init__(self, points: Array) -> None:
        self.points = points

    @cached_property
    def _sorted(self) -> tuple[Array, int, Ints, Rows]:
        """The first cell (2,), cells along y, and each point's cell in order, with its row."""
        cells = np.floor(self.points[:, :2] / _CELL_M).astype(np.int64)
        first = cells.min(axis=0)
        count = int(np.ptp(cells[:, 1])) + 1
        keys = (cells[:, 0] - first[0]) * count + cells[:, 1] - first[1]
        order = np.argsort(keys, kind="stable")
        return first, count, keys[order], order

    def rows(self, low: Array, high: Array) -> Rows:
        """Ascending rows of points, of which those from (2,) to (2,), metres, are all."""
        if not len(self.points):
            return np.zeros(0, np.intp)
        first, count, keys, order = self._sorted
        most = np.array([keys[-1] // count, count - 1])
        begin = np.clip(np.floor(low / _CELL_M) - first, 0, most + 1).astype(np.int64)
        end = np.clip(np.floor(high / _CELL_M) - first, -1, most).astype(np.int64)
        columns = np.arange(begin[0], end[0] + 1) * count
        if not len(columns) or end[1] < begin[1]:
            return np.zeros(0, np.intp)
        starts = np.searchsorted(keys, columns + begin[1])
        stops = np.searchsorted(keys, columns + end[1], side="right")
        parts = [order[a:b] for a, b in zip(starts, stops, strict=True)]
        return np.asarray(np.sort(np.concatenate(parts)))
