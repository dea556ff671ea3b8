"""Maximum-sum rectangles in grids of weights, and the strips around a rectangle."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array

# The exact search runs on blocks of cells; edges are then refined cell by cell.
_COARSE_STEP_CELLS: Final = 3
_MAX_REFINEMENTS: Final = 10


@dataclass(frozen=True)
class Rectangle:
    """Rows and columns of a picture, the last ones not included."""

    bottom: int
    top: int
    left: int
    right: int

    @property
    def rows(self) -> slice:
        """From the bottom to the top."""
        return slice(self.bottom, self.top)

    @property
    def columns(self) -> slice:
        """From left to right."""
        return slice(self.left, self.right)

    @property
    def area(self) -> int:
        """The number of its cells."""
        return (self.top - self.bottom) * (self.right - self.left)

    def of(self, picture: NDArray[np.generic]) -> NDArray[np.generic]:
        """What lies inside."""
        return picture[self.rows, self.columns]


def best_rectangle(weights: Array, least_rows: int = 1) -> tuple[Rectangle, float]:
    """The maximum-sum rectangle of a grid.

    Exact on blocks of cells (Kadane's algorithm along the columns for every pair of rows), then
    refined cell by cell while the sum grows.

    Args:
        weights: (Z, X) positive where cells should be inside.
        least_rows: Least height; a grid with fewer rows is taken whole.
    """
    blocks = _blocks(weights)
    bottom, top, left, right = _kadane(
        blocks, min(-(-least_rows // _COARSE_STEP_CELLS), len(blocks))
    )
    limits = weights.shape
    found = Rectangle(
        _COARSE_STEP_CELLS * bottom,
        min(_COARSE_STEP_CELLS * top, limits[0]),
        _COARSE_STEP_CELLS * left,
        min(_COARSE_STEP_CELLS * right, limits[1]),
    )
    return _refined(found, _summed(weights), limits, least_rows)


def _blocks(weights: Array) -> Array:
    rows, columns = (-size % _COARSE_STEP_CELLS for size in weights.shape)
    padded = np.pad(weights, ((0, rows), (0, columns)))
    shape = (
        padded.shape[0] // _COARSE_STEP_CELLS,
        _COARSE_STEP_CELLS,
        padded.shape[1] // _COARSE_STEP_CELLS,
        _COARSE_STEP_CELLS,
    )
    return np.asarray(padded.reshape(shape).sum(axis=(1, 3)))


def _kadane(weights: Array, least_rows: int) -> tuple[int, int, int, int]:
    """Bottom, top, left and right of the maximum-sum subarray."""
    stacked = np.vstack([np.zeros(weights.shape[1]), weights.cumsum(axis=0)])
    low, high = np.triu_indices(len(stacked), least_rows)
    # For each pair of rows, the largest difference of prefix sums along the columns.
    sums = np.pad((stacked[high] - stacked[low]).cumsum(axis=1), ((0, 0), (1, 0)))
    least = np.minimum.accumulate(sums, axis=1)
    gain = sums[:, 1:] - least[:, :-1]
    pair, right = np.unravel_index(int(gain.argmax()), gain.shape)
    left = int(sums[pair, : right + 1].argmin())
    return int(low[pair]), int(high[pair]), left, int(right) + 1


def _summed(weights: Array) -> Array:
    """(Z + 1, X + 1) summed-area table."""
    return np.pad(weights.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))


def _sum(total: Array, r: Rectangle) -> float:
    corners = total[[r.top, r.bottom]][:, [r.right, r.left]]
    return float(corners[0, 0] - corners[0, 1] - corners[1, 0] + corners[1, 1])


def _refined(
    found: Rectangle, total: Array, limits: tuple[int, ...], least_rows: int
) -> tuple[Rectangle, float]:
    value = _sum(total, found)
    for _ in range(_MAX_REFINEMENTS):
        moves = [r for r in _moves(found, limits) if r.top - r.bottom >= least_rows]
        tried = [found, *moves]
        sums = [_sum(total, moved) for moved in tried]
        if max(sums) <= value:
            break
        value, found = max(sums), tried[int(np.argmax(sums))]
    return found, value


def _moves(r: Rectangle, limits: tuple[int, ...]) -> Iterator[Rectangle]:
    edges = np.array([r.bottom, r.top, r.left, r.right])
    for edge in range(4):
        for step in (-2, -1, 1, 2):
            moved = edges.copy()
            moved[edge] += step
            bottom, top, left, right = (int(value) for value in moved)
            if 0 <= bottom < top <= limits[0] and 0 <= left < right <= limits[1]:
                yield Rectangle(bottom, top, left, right)


def ring(shape: tuple[int, int], r: Rectangle, width: int) -> dict[str, Rectangle]:
    """The strips of cells around a rectangle within the grid, by side."""
    bottom, top = max(r.bottom - width, 0), min(r.top + width, shape[0])
    left, right = max(r.left - width, 0), min(r.right + width, shape[1])
    strips = {
        "left": Rectangle(r.bottom, r.top, left, r.left),
        "right": Rectangle(r.bottom, r.top, r.right, right),
        "top": Rectangle(r.top, top, r.left, r.right),
        "bottom": Rectangle(bottom, r.bottom, r.left, r.right),
    }
    return {side: strip for side, strip in strips.items() if strip.area > 0}
