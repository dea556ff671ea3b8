"""At which height something rests on what is not level: stacks, seats, bedding, bowls."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.generate.boxes import Array, Pose
from openrooms_usd.generate.clutter.levels import crossings, edge_cells
from openrooms_usd.generate.shapes import Shape
from openrooms_usd.geometry.rotations import about_z

# Of a relief's cells, metres.
RELIEF_CELL_M: Final = 0.005
# Things touch each other within this of their lowest and highest points, metres.
_CONTACT_M: Final = 0.03
_MOST_CONTACTS: Final = 500
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


def relief_of(shape: Shape) -> Relief:
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


def skin_of(shape: Shape) -> Array:
    """(N, 3) corners of an object's triangles, and points between them; metres."""
    points = np.concatenate([mesh.points for mesh in shape.meshes])
    between = 0.5 * (shape.corners + np.roll(shape.corners, -1, axis=1))
    return np.concatenate([points, between.reshape(-1, 3), shape.corners.mean(axis=1)])


def rest_on(below: Shape, below_skin: Array, upper: Shape, upper_skin: Array, pose: Pose) -> float:
    """How high an object's origin is that comes down on another: points of each on faces of both.

    Args:
        below: What carries it.
        below_skin: (N, 3) points of its surface, metres.
        upper: The object.
        upper_skin: (M, 3) points of its surface, metres.
        pose: Of the object in the carrier's frame.
    """
    x, y, yaw = pose
    low = few(upper_skin[upper_skin[:, 2] < upper_skin[:, 2].min() + _CONTACT_M])
    points = low @ about_z(np.radians(yaw)).T
    found = below.tops(x + points[:, 0], y + points[:, 1]) - points[:, 2]
    high = few(below_skin[below_skin[:, 2] > below_skin[:, 2].max() - _CONTACT_M])
    local = (high - np.array([x, y, 0.0])) @ about_z(np.radians(yaw))
    over = Shape(tuple(mesh.transformed(_UPSIDE_DOWN) for mesh in upper.meshes))
    other = over.tops(local[:, 0], local[:, 1]) + high[:, 2]
    return float(max(found.max(), other.max()))


def few(points: Array, most: int = _MOST_CONTACTS) -> Array:
    """Some of many points, spread over all of them."""
    return points[:: 1 + len(points) // most]
