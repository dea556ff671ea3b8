"""Walls of rooms as segments with inward normals, for contacts with objects."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.results import FoundRoom

# Walls farther than this from an object's bounding circle do not touch it, metres.
_WALL_REACH_M: Final = 0.4


@dataclass(frozen=True, eq=False)
class Walls:
    """W straight walls.

    Attributes:
        starts: (W, 2) metres.
        ends: (W, 2) metres.
        normals: (W, 2) unit, into the room.
    """

    starts: Array
    ends: Array
    normals: Array

    def near(self, place: Array, radius: float) -> "Walls":
        """The walls that a disc is close to, or intersects, on their inner side."""
        along = self.ends - self.starts
        length = np.linalg.norm(along, axis=1)
        unit = along / np.maximum(length, 1e-9)[:, None]
        offset = place[:2] - self.starts
        station = np.einsum("ij,ij->i", offset, unit)
        depth = np.einsum("ij,ij->i", offset, self.normals)
        kept = (station > -0.5 * radius) & (station < length + 0.5 * radius)
        kept &= (depth > -0.5 * radius) & (depth < radius + _WALL_REACH_M)
        return Walls(self.starts[kept], self.ends[kept], self.normals[kept])


def walls_of(rooms: Sequence[FoundRoom]) -> Walls:
    """All walls of some rooms."""
    starts = [room.corners[:, :2] for room in rooms] or [np.empty((0, 2))]
    ends = [np.roll(corners, -1, axis=0) for corners in starts]
    a, b = np.concatenate(starts), np.concatenate(ends)
    along = (b - a) / np.maximum(np.linalg.norm(b - a, axis=1), 1e-9)[:, None]
    return Walls(a, b, np.stack([-along[:, 1], along[:, 0]], axis=1))


NO_WALLS: Final = walls_of(())
