"""How much of rooms a scan shows: the parts of their floors and walls with points near them.

Counted on cells of 10 cm. A cell is shown where a point lies within 10 cm of its middle, or where
something was scanned that hides it: above the floor, or before the wall.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.floorplan import inside
from openrooms_usd.scan.results import FoundOpening, FoundRoom

_CELL_M: Final = 0.1
_NEAR_M: Final = 0.1
# What hides a cell stands within this of it: a table above the floor, a shelf before the wall.
_BEFORE_M: Final = 1.0
# Rooms whose ceiling no scan shows are taken to be so high; below it walls are to be seen.
_HEIGHT_M: Final = 2.4


@dataclass(frozen=True)
class Shown:
    """How much of a room a scan shows.

    Attributes:
        floor: The part of the floor, from 0 to 1.
        walls: The part of the walls without their openings.
        whole: The part of both together.
    """

    floor: float
    walls: float
    whole: float

    def as_dict(self) -> dict[str, float]:
        """Plain data, for records."""
        return {"floor": self.floor, "walls": self.walls, "whole": self.whole}


def shown(points: Array, rooms: Sequence[FoundRoom]) -> Shown:
    """How much of rooms a scan shows, all together.

    Args:
        points: (N, 3) of the scan, Z up, metres.
        rooms: In the same frame, their floors level.
    """
    from scipy.spatial import cKDTree

    tree, up = cKDTree(points), np.array([0.0, 0.0, 1.0])
    walls = [wall for room in rooms for wall in _wall_cells(room)]
    seen_floor = np.concatenate([_is_observed(tree, _floor_cells(room), up) for room in rooms])
    seen_walls = np.concatenate([_is_observed(tree, cells, inward) for cells, inward in walls])
    both = np.concatenate([seen_floor, seen_walls])
    return Shown(*(round(float(part.mean()), 4) for part in (seen_floor, seen_walls, both)))


def _is_observed(tree: Any, cells: Array, inward: Array) -> Mask:
    """(C,) whether a point lies at each cell, or in the way to it."""
    found = np.zeros(len(cells), dtype=bool)
    # Steps of half a sphere's width: between spheres that only touch, a table's top would be lost.
    for away in np.arange(0.0, _BEFORE_M, _NEAR_M):
        rest = np.flatnonzero(~found)
        distance, _ = tree.query(cells[rest] + away * inward, distance_upper_bound=_NEAR_M)
        found[rest] = np.isfinite(distance)
    return found


def _floor_cells(room: FoundRoom) -> Array:
    """(C, 3) the middles of cells of the floor."""
    corners = room.corners[:, :2]
    low, high = corners.min(axis=0), corners.max(axis=0)
    axes = [np.arange(a + 0.5 * _CELL_M, b, _CELL_M) for a, b in zip(low, high, strict=True)]
    plan = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    plan = plan[inside(corners, plan)]
    return np.column_stack([plan, np.full(len(plan), room.corners[:, 2].mean())])


def _wall_cells(room: FoundRoom) -> Iterator[tuple[Array, Array]]:
    """Of each wall the (C, 3) middles of cells outside of its openings, and where the room is."""
    height = room.ceiling or _HEIGHT_M
    levels = room.corners[0, 2] + np.arange(0.5 * _CELL_M, height, _CELL_M)
    for number, (start, end) in enumerate(pairwise([*room.corners, room.corners[0]])):
        way = (end - start)[:2]
        length = float(np.linalg.norm(way))
        along = np.arange(0.5 * _CELL_M, length, _CELL_M)
        u, z = (part.ravel() for part in np.meshgrid(along, levels))
        free = np.ones(len(u), dtype=bool)
        for opening in room.openings:
            if opening.wall == number:
                free &= ~_within(opening, start, way / length, u, z)
        plan = start[:2] + u[free, None] * way / length
        # Corners go round counter-clockwise: the room is on the left.
        yield np.column_stack([plan, z[free]]), np.array([-way[1], way[0], 0.0]) / length


def _within(opening: FoundOpening, start: Array, along: Array, u: Array, z: Array) -> Mask:
    """(C,) whether cells of a wall lie in an opening's rectangle."""
    across = (opening.corners[:, :2] - start[:2]) @ along
    levels = opening.corners[:, 2]
    return np.asarray(
        (u > across.min()) & (u < across.max()) & (z > levels.min()) & (z < levels.max())
    )
