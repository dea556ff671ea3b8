"""Can people get about: free floor on a fine grid, thinned by half of a person's width."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.generation.boxes import distance, reach
from openrooms_usd.generation.items import HEADROOM_M, STEP_M
from openrooms_usd.generation.shell import Shell

CELL_M: Final = 0.05
# Half the width of the narrowest path, metres; cells are this far from everything, and a bit.
HALF_PATH: Final = 0.3
# How near to a place the free floor must come so that a person can use it, metres.
REACH_M: Final = 0.3
# What is cut off is so much narrower than the widest floor that is not, metres (half of it).
_NARROWER_M: Final = 0.1
# What is farther away than this does not matter, metres.
_MAX_CLEARANCE_M: Final = 1.0


@dataclass(frozen=True, eq=False)
class Floor:
    """Distances of floor cells to the nearest obstacle.

    Attributes:
        origin: (2,) middle of the first cell, metres.
        clear: (H, W) distance of each cell to walls and obstacles, clipped; metres.
        doors: (D, 2) where people stand when they have come in, metres.
    """

    origin: Array
    clear: Array
    doors: Array

    def with_boxes(self, boxes: Array) -> "Floor":
        """The floor with further furniture on it."""
        clear = self.clear.copy()
        for row in boxes:
            if row[6] >= HEADROOM_M or row[7] <= STEP_M:
                continue
            x0, y0, x1, y1 = reach(row[None])
            low = np.array([x0, y0]) - self.origin - _MAX_CLEARANCE_M
            high = np.array([x1, y1]) - self.origin + _MAX_CLEARANCE_M
            i0, j0 = np.maximum(np.floor(low / CELL_M).astype(int), 0)
            i1, j1 = np.ceil(high / CELL_M).astype(int) + 1
            part = clear[j0:j1, i0:i1]
            if part.size:
                x, y = self._middles(i0, j0, part.shape)
                np.minimum(part, distance(row[None], x, y)[..., 0], out=part)
        return Floor(self.origin, clear, self.doors)

    def _middles(self, i0: int, j0: int, shape: tuple[int, ...]) -> tuple[Array, Array]:
        x = self.origin[0] + CELL_M * (i0 + np.arange(shape[1]))
        y = self.origin[1] + CELL_M * (j0 + np.arange(shape[0]))
        return x[None, :] + 0.0 * y[:, None], y[:, None] + 0.0 * x[None, :]

    def connected(self) -> Mask | None:
        """(H, W) the cells that people can reach from all doors.

        None when a door is cut off, or floor that is as wide as what can be reached.
        """
        free = self.clear >= HALF_PATH
        labels = components(free)
        found = {self._label(labels, x, y) for x, y in self.doors}
        if len(found) != 1 or 0 in found:
            return None
        reachable = np.asarray(labels == found.pop())
        beyond = self.clear[free & ~reachable].max(initial=0.0)
        return reachable if beyond < self.clear[reachable].max() - _NARROWER_M else None

    def _label(self, labels: Ints, x: float, y: float) -> int:
        i, j = self._cell(x, y)
        near = labels[max(j - 1, 0) : j + 2, max(i - 1, 0) : i + 2]
        return int(near.max(initial=0))

    def _cell(self, x: float, y: float) -> tuple[int, int]:
        i, j = np.round((np.array([x, y]) - self.origin) / CELL_M).astype(int).tolist()
        return i, j

    def reaches(self, reachable: Mask, places: Iterable[tuple[float, float]]) -> bool:
        """Whether people can come near to all of some places."""
        n = round(REACH_M / CELL_M)
        for x, y in places:
            i, j = self._cell(x, y)
            if not reachable[max(j - n, 0) : j + n + 1, max(i - n, 0) : i + n + 1].any():
                return False
        return True


def floor_of(shell: Shell) -> Floor:
    """The floor of a room without furniture."""
    low, high = shell.corners.min(axis=0), shell.corners.max(axis=0)
    columns, rows = np.ceil((high - low) / CELL_M).astype(int)
    x = low[0] + CELL_M * (np.arange(columns) + 0.5)
    y = low[1] + CELL_M * (np.arange(rows) + 0.5)
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    clear = np.full((rows, columns), _MAX_CLEARANCE_M)
    for wall in shell.walls:
        np.minimum(clear, distance(wall[None], grid[..., 0], grid[..., 1])[..., 0], out=clear)
    clear[~shell.contains(grid)] = 0.0
    doors = [shell.sides[gap.side].point(gap.at, HALF_PATH + 0.1) for gap in shell.doors]
    return Floor(low + 0.5 * CELL_M, clear, np.array(doors).reshape(-1, 2))


def components(free: Mask) -> Ints:
    """Number the connected parts (4 neighbours) of a mask; 0 is outside of it.

    Runs of each row are joined with those that they touch in the row before (union by path).
    """
    height, width = free.shape
    padded = np.zeros((height, width + 2), dtype=np.int8)
    padded[:, 1:-1] = free
    step = np.diff(padded, axis=1)
    row, start = np.nonzero(step == 1)
    _, end = np.nonzero(step == -1)
    parent = list(range(len(row)))

    def root(a: int) -> int:
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        return a

    first = np.searchsorted(row, np.arange(height + 1)).tolist()
    starts, ends = start.tolist(), end.tolist()
    for y in range(1, height):
        a, b = first[y - 1], first[y]
        while a < first[y] and b < first[y + 1]:
            if starts[a] < ends[b] and starts[b] < ends[a]:
                parent[root(a)] = root(b)
            if ends[a] < ends[b]:
                a += 1
            else:
                b += 1
    labels = np.zeros((height, width), dtype=np.int64)
    for run in range(len(parent)):
        labels[row[run], starts[run] : ends[run]] = root(run) + 1
    return labels
