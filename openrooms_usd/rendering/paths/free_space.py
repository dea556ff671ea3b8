"""Where in a room a camera can go at eye level, found by casting rays."""

import heapq
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.errors import RenderError
from openrooms_usd.geometry.raycast import RayCaster

Cell = tuple[int, int]

_CELL_M: Final = 0.15
_MOST_CELLS_A_SIDE: Final = 160
_FARTHEST_WALL_M: Final = 15.0
# A camera needs this much room around it, and above what it passes over.
CLEARANCE_M: Final = 0.3
_HEADROOM_M: Final = 0.4
# Walls and furniture are looked for at these heights, relative to the eye.
_LEVELS_M: Final = (-0.35, -0.15, 0.0, 0.15)
# What lies higher above the floor is furniture, and it is worth a detour not to pass over it.
_FLOOR_M: Final = 0.2
_WAY_OVER_FURNITURE: Final = 4.0
_STEPS: Final = tuple((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j)


class FreeSpace:
    """The cells of a plan at eye level that can be reached from a place.

    Args:
        caster: The room.
        start: (3,) where a camera is.

    Attributes:
        level: Height of the eye, metres.
        usable: (C, 2) columns and rows of cells with room around them.

    Raises:
        RenderError: There is no room around the place.
    """

    def __init__(self, caster: RayCaster, start: Array) -> None:
        self._caster, self.level = caster, float(start[2])
        turns = np.linspace(0.0, 2.0 * np.pi, 128, endpoint=False)
        around = np.column_stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)])
        reach = np.minimum(caster.first_hit(start, around).distance, _FARTHEST_WALL_M)
        ends = start + around * reach[:, None]
        # Beyond the walls that are seen there may be more of the room, behind a corner.
        self._low = ends[:, :2].min(axis=0) - 1.0
        size = ends[:, :2].max(axis=0) + 1.0 - self._low
        self._step = max(_CELL_M, float(size.max()) / _MOST_CELLS_A_SIDE)
        self._shape = tuple(int(n) for n in np.ceil(size / self._step).astype(int) + 1)
        standing, self._cost = self._standing()
        reached = self._reached(standing, self.cell(start))
        self._clearance = _distances(reached) * self._step
        for room in (CLEARANCE_M, 0.5 * CLEARANCE_M, 0.0):
            self._free = self._clearance > room
            if self._free.any():
                break
        else:
            raise RenderError("there is no space for a walk around the camera", place=str(start))
        self.usable: Ints = np.argwhere(self._free)

    def cell(self, place: Array) -> Cell:
        """The cell of a point of the plan; the nearest one for points outside."""
        (i,), (j,) = self._cells(np.asarray(place)[None])
        return int(i), int(j)

    def places(self, cells: Ints) -> Array:
        """(C, 3) middles of (C, 2) cells at eye level."""
        plan = self._low + np.asarray(cells, dtype=np.float64) * self._step
        return np.column_stack([plan, np.full(len(plan), self.level)])

    def nearest(self, place: Array) -> tuple[Cell, float]:
        """The usable cell that is nearest to a point, and how far it is in the plan, metres."""
        apart = np.linalg.norm(self.places(self.usable)[:, :2] - np.asarray(place)[:2], axis=1)
        best = int(np.argmin(apart))
        i, j = self.usable[best]
        return (int(i), int(j)), float(apart[best])

    def is_free(self, places: Array) -> Mask:
        """(N,) whether there is room around (N, 3) places."""
        i, j = self._cells(places)
        return np.asarray(self._free[i, j])

    def is_over_furniture(self, places: Array) -> Mask:
        """(N,) whether something lower than the eye stands below (N, 3) places."""
        i, j = self._cells(places)
        return np.asarray(self._cost[i, j] > 1.0)

    def way(self, start: Cell, goal: Cell) -> Ints:
        """(N, 2) cells of the best way between two usable cells; empty where there is none.

        A long way over the floor is better than a short one over furniture or along a wall
        (E. W. Dijkstra, A note on two problems in connexion with graphs, 1959).
        """
        best, before = {start: 0.0}, {}
        queue = [(0.0, start)]
        while queue:
            length, here = heapq.heappop(queue)
            if here == goal:
                break
            if length > best[here]:
                continue
            for i, j in _STEPS:
                there = here[0] + i, here[1] + j
                if not self._holds(there):
                    continue
                cost = self._cost[there] * (1.0 + CLEARANCE_M / float(self._clearance[there]))
                total = length + float(np.hypot(i, j)) * cost
                if total < best.get(there, np.inf):
                    best[there], before[there] = total, here
                    heapq.heappush(queue, (total, there))
        if goal not in best:
            return np.zeros((0, 2), dtype=np.int64)
        cells = [goal]
        while cells[-1] != start:
            cells.append(before[cells[-1]])
        return np.array(cells[::-1], dtype=np.int64)

    def _cells(self, places: Array) -> Ints:
        """(2, N) columns and rows of the cells of (N, 3) places; the nearest ones for outside."""
        at = np.rint((places[:, :2] - self._low) / self._step).astype(np.int64)
        return np.asarray(np.clip(at, 0, np.array(self._shape) - 1).T)

    def _holds(self, cell: Cell) -> bool:
        i, j = cell
        return 0 <= i < self._shape[0] and 0 <= j < self._shape[1] and bool(self._free[i, j])

    def _standing(self) -> tuple[Mask, Array]:
        """Cells with something below that is low enough, and what a way over them costs."""
        cells = np.argwhere(np.ones(self._shape, dtype=bool))
        down = self._caster.first_hit(
            self.places(cells), np.tile([0.0, 0.0, -1.0], (len(cells), 1))
        )
        height = (self.level - down.distance).reshape(self._shape)
        low = np.isfinite(height) & (height < self.level - _HEADROOM_M)
        floor = np.percentile(height[low], 5) if low.any() else 0.0
        return low, np.where(height > floor + _FLOOR_M, _WAY_OVER_FURNITURE, 1.0)

    def _reached(self, standing: Mask, start: Cell) -> Mask:
        """Cells that can be reached from one through nothing that stands in the way."""
        passages = {step: self._passage(step) for step in ((1, 0), (0, 1))}
        reached, queue = np.zeros(self._shape, dtype=bool), [start]
        reached[start] = standing[start]
        while queue and standing[start]:
            i, j = queue.pop()
            for (di, dj), passage in passages.items():
                for there, gate in (
                    ((i + di, j + dj), (i, j)),
                    ((i - di, j - dj), (i - di, j - dj)),
                ):
                    inside = 0 <= there[0] < self._shape[0] and 0 <= there[1] < self._shape[1]
                    if inside and standing[there] and passage[gate] and not reached[there]:
                        reached[there] = True
                        queue.append(there)
        return reached

    def _passage(self, step: Cell) -> Mask:
        """Whether nothing stands between each cell and its neighbour, at any of the heights."""
        cells = np.argwhere(np.ones(self._shape, dtype=bool))
        middles = self.places(cells)
        free = np.ones(len(cells), dtype=bool)
        for height in _LEVELS_M:
            begin = middles + np.array([0.0, 0.0, height])
            along = np.tile([float(step[0]), float(step[1]), 0.0], (len(cells), 1))
            free &= ~self._caster.occluded(begin, along, self._step)
        return free.reshape(self._shape)


def _distances(inside: Mask) -> Array:
    """Cells from each cell that is inside to the nearest that is not."""
    from scipy.ndimage import distance_transform_edt

    found: Array = distance_transform_edt(np.pad(inside, 1))[1:-1, 1:-1]
    return found
