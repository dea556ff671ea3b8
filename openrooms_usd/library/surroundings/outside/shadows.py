"""What the sun does not reach: the height below which each place of the land lies in shadow."""

import math
from typing import Final

import numpy as np

from openrooms_usd.library.surroundings.outside.noise import Floats

# The land that is looked at: half its side and a cell of its grid, metres.
_REACH_M: Final = 88.0
_CELL_M: Final = 0.44
# Half the height over which light fades into shadow, metres.
_SOFT_M: Final = 0.35
# Below this the sun's shadows reach everywhere.
_LOWEST_SUN: Final = math.sin(math.radians(3.0))
_MAX_STEPS: Final = 240
_ALL: Final = (slice(None), slice(None))


class Shadows:
    """A map of heights, and once the sun is up what it leaves in shadow."""

    def __init__(self) -> None:
        """Level land."""
        self._side = round(2.0 * _REACH_M / _CELL_M)
        places = ((np.arange(self._side) + 0.5) * _CELL_M - _REACH_M).astype(np.float32)
        self.x, self.y = places[None, :], places[:, None]
        self._heights = np.zeros((self._side, self._side), dtype=np.float32)
        self._limit: Floats | None = None

    def stand(
        self, heights: Floats, part: tuple[slice, slice] = (slice(None), slice(None))
    ) -> None:
        """Something stands there: (S, S) heights at ``x`` and ``y``, metres above the land.

        Args:
            heights: Of that part of the map.
            part: Its rows and columns.
        """
        np.maximum(self._heights[part], heights, out=self._heights[part])

    def around(self, x: float, y: float, reach: float) -> tuple[slice, slice]:
        """The rows and columns of the map within a distance of a place."""
        low, high = (
            [
                int(np.clip((at + side * reach + _REACH_M) / _CELL_M + side, 0, self._side))
                for at in (y, x)
            ]
            for side in (-1, 1)
        )
        return slice(low[0], high[0]), slice(low[1], high[1])

    def cast(self, sun: Floats) -> None:
        """Find the shadows of a sun in direction (3,)."""
        if sun[2] < _LOWEST_SUN:
            self._limit = None
            return
        flat = sun[:2] / max(float(np.abs(sun[:2]).max()), 1e-6)
        rise = float(sun[2] / np.hypot(*sun[:2]) * np.hypot(*flat)) * _CELL_M
        limit = np.full_like(self._heights, -1.0)
        highest = float(self._heights.max())
        for count in range(1, _MAX_STEPS):
            if count * rise > highest:
                break
            moved = self._heights_shifted(count * float(flat[0]), count * float(flat[1]))
            np.maximum(limit, moved - count * rise, out=limit)
        self._limit = limit

    def _heights_shifted(self, right: float, up: float) -> Floats:
        """Heights so many cells away."""
        pad = np.zeros_like(self._heights)
        columns, rows = round(right), round(up)
        n = self._side
        target = (
            slice(max(0, -rows), n - max(0, rows)),
            slice(max(0, -columns), n - max(0, columns)),
        )
        source = (
            slice(max(0, rows), n + min(0, rows)),
            slice(max(0, columns), n + min(0, columns)),
        )
        pad[target] = self._heights[source]
        return pad

    def lit(self, x: Floats, y: Floats, z: Floats) -> Floats:
        """The part of the sun that reaches points at heights above the land; metres."""
        if self._limit is None:
            return np.ones(1, dtype=np.float32)
        column, row = (np.broadcast_arrays(x, y)[i] + _REACH_M for i in (0, 1))
        column, row = column / _CELL_M - 0.5, row / _CELL_M - 0.5
        left, top = np.floor(column), np.floor(row)
        across, down = column - left, row - top
        last = self._side - 2
        left = np.clip(left, 0, last).astype(np.int32)
        top = np.clip(top, 0, last).astype(np.int32)
        limit = self._limit
        upper = limit[top, left] * (1.0 - across) + limit[top, left + 1] * across
        lower = limit[top + 1, left] * (1.0 - across) + limit[top + 1, left + 1] * across
        edge = upper * (1.0 - down) + lower * down
        inside = (np.abs(x) < _REACH_M - 1.0) & (np.abs(y) < _REACH_M - 1.0)
        part = np.clip((z - edge) / (2.0 * _SOFT_M) + 0.5, 0.0, 1.0)
        return np.asarray(np.where(inside, part, 1.0), dtype=np.float32)
