"""At which height something rests on what is not level: stacks, seats, bedding, bowls."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.generation.clutter.levels import crossings, edge_cells
from openrooms_usd.generation.shapes import BuiltForm, tops

# Of a relief's cells, metres.
RELIEF_CELL_M: Final = 0.005
# Between the lines along which things come down on others: at least so many metres, and no more
# lines than this side by side. Corners stand out by less from the faces where the next line meets
# them, metres.
_LINE_M: Final = 0.002
_LINES: Final = 80
_STEP_M: Final = 0.004
_MOST_CORNERS: Final = 200
_UPSIDE_DOWN: Final = np.diag([1.0, 1.0, -1.0])
# No more points of a thing than this are looked at.
_MOST_POINTS: Final = 5000


@dataclass(frozen=True, eq=False)
class Relief:
    """The upper side of an object on a fine grid, in its own frame.

    Attributes:
        origin: (2,) the least corner of the first cell, metres.
        heights: (H, W) metres; -inf where there is nothing.
    """

    origin: Array
    heights: Array

    def at(self, x: Array, y: Array) -> Array:
        """(...) heights at places; -inf beside it."""
        i = np.floor((x - self.origin[0]) / RELIEF_CELL_M).astype(int)
        j = np.floor((y - self.origin[1]) / RELIEF_CELL_M).astype(int)
        height, width = self.heights.shape
        there = (i >= 0) & (i < width) & (j >= 0) & (j < height)
        found = self.heights[np.clip(j, 0, height - 1), np.clip(i, 0, width - 1)]
        return np.asarray(np.where(there, found, -np.inf))

    def rest(self, points: Array, x: Array, y: Array) -> Array:
        """(P,) how high an object's origin is when it comes down at places.

        Args:
            points: (N, 3) of the object, turned as it lies; metres.
            x: (P,) metres.
            y: (P,) metres.
        """
        points = points[:: 1 + len(points) // _MOST_POINTS]
        below = self.at(x[:, None] + points[:, 0], y[:, None] + points[:, 1])
        return np.asarray((below - points[:, 2]).max(axis=1))


def relief_of(shape: BuiltForm) -> Relief:
    """The upper side of an object: of each cell the highest of its middle and all edges in it."""
    corners = shape.corners
    low = corners.reshape(-1, 3).min(axis=0)[:2] - 1e-4
    high = corners.reshape(-1, 3).max(axis=0)[:2]
    columns, rows = (np.floor((high - low) / RELIEF_CELL_M).astype(int) + 1).tolist()
    heights = np.full(rows * columns, -np.inf)
    cell, z, _ = crossings(corners, low, columns, rows, RELIEF_CELL_M)
    np.maximum.at(heights, cell, z)
    cell, z, _ = edge_cells(corners, low, columns, RELIEF_CELL_M)
    np.maximum.at(heights, cell, z)
    return Relief(low, heights.reshape(rows, columns))


def skin_of(shape: BuiltForm) -> Array:
    """(N, 3) corners of an object's triangles, and points between them; metres."""
    points = np.concatenate([mesh.points for mesh in shape.meshes])
    between = 0.5 * (shape.corners + np.roll(shape.corners, -1, axis=1))
    return np.concatenate([points, between.reshape(-1, 3), shape.corners.mean(axis=1)])


def rest_on(below: Array, upper: Array) -> float:
    """How far an object that comes down on another is lifted until it rests on it.

    Vertical lines through both say how near their faces are, and what stands out between the
    lines has corners: those are looked at exactly.

    Args:
        below: (T, 3, 3) corners of the triangles of what carries it, metres.
        upper: (U, 3, 3) those of the object, turned and above its place there; metres.

    Returns:
        Metres; -inf where it passes by.
    """
    bounds = [(c.min(axis=(0, 1))[:2], c.max(axis=(0, 1))[:2]) for c in (below, upper)]
    low, high = np.maximum(bounds[0][0], bounds[1][0]), np.minimum(bounds[0][1], bounds[1][1])
    if (high <= low).any():
        return -np.inf
    over = _Lines.through(below, low, high)
    under = _Lines.through(upper @ _UPSIDE_DOWN, low, high)
    met = float((over.heights + under.heights).max())
    sides = ((over, upper), (under, below @ _UPSIDE_DOWN))
    return max(met, *(lines.lift(corners.reshape(-1, 3), met) for lines, corners in sides))


@dataclass(frozen=True, eq=False)
class _Lines:
    """Where vertical lines on a grid meet triangles last.

    Attributes:
        corners: (T, 3, 3) of those triangles that come near, metres.
        low: (2,) the least corner of the grid, metres.
        side: Between lines, metres.
        heights: (H, W) metres; -inf where they miss all.
    """

    corners: Array
    low: Array
    side: float
    heights: Array

    @staticmethod
    def through(corners: Array, low: Array, high: Array) -> "_Lines":
        """Lines over a rectangle of the plan."""
        plan = corners[..., :2]
        near = ((plan.min(axis=1) <= high) & (plan.max(axis=1) >= low)).all(axis=1)
        side = max(_LINE_M, float((high - low).max()) / _LINES)
        columns, rows = (np.floor((high - low) / side).astype(int) + 1).tolist()
        heights = np.full(rows * columns, -np.inf)
        cell, z, _ = crossings(corners[near], low, columns, rows, side)
        np.maximum.at(heights, cell, z)
        return _Lines(corners[near], low, side, heights.reshape(rows, columns))

    def lift(self, points: Array, met: float) -> float:
        """How far points must be lifted to be above the triangles, if farther than known."""
        cells = np.floor((points[:, :2] - self.low) / self.side).astype(int)
        there = ((cells >= 0) & (cells < self.heights.shape[::-1])).all(axis=1)
        points, (i, j) = points[there], cells[there].T
        near = self.heights[j, i] - points[:, 2] > met - _STEP_M
        points = np.unique(points[near], axis=0)
        points = points[:: 1 + len(points) // _MOST_CORNERS]
        if not len(points):
            return -np.inf
        return float((tops(self.corners, points[:, 0], points[:, 1]) - points[:, 2]).max())
