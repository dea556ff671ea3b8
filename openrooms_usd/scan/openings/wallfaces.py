"""The inner faces of a room's walls, each with its own frame as seen from inside."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Largest distance of a wall's own returns, in the room and behind it, metres.
REACH_M: Final = 0.35
# Resolution of the map of nearest walls, metres.
_PLAN_CELL_M: Final = 0.02


@dataclass(frozen=True, eq=False)
class WallFace:
    """The inner face of a wall in the plan.

    Attributes:
        number: From corner ``number`` of the room to the next.
        left: (2,) its left end, seen from inside.
        along: (2,) unit vector to the right.
        length: Metres.
    """

    number: int
    left: Array
    along: Array
    length: float

    @property
    def outward(self) -> Array:
        """(2,) unit vector away from the room."""
        return np.array([-self.along[1], self.along[0]])

    def from_level(self, points: Array) -> Array:
        """Transform (N, 3) points from the level frame to the wall's."""
        offset = points[:, :2] - self.left
        return np.column_stack([offset @ self.along, offset @ self.outward, points[:, 2]])

    def to_level(self, points: Array) -> Array:
        """Transform (N, 3) points from the wall's frame to the level frame."""
        plan = self.left + points[:, :1] * self.along + points[:, 1:2] * self.outward
        return np.column_stack([plan, points[:, 2]])


def faces_of(corners: Array) -> tuple[WallFace, ...]:
    """The inner faces of a room's walls.

    Args:
        corners: (N, 2) counter-clockwise, metres.
    """
    # Counter-clockwise edges run from right to left, seen from inside.
    lefts = np.roll(corners, -1, axis=0)
    lengths = np.linalg.norm(corners - lefts, axis=1)
    return tuple(
        WallFace(i, lefts[i], (corners[i] - lefts[i]) / max(lengths[i], 1e-9), float(lengths[i]))
        for i in range(len(corners))
    )


def nearest_walls(points: Array, corners: Array, faces: Sequence[WallFace]) -> NDArray[np.int16]:
    """The wall that each point is closest to in the plan.

    Args:
        points: (N, 3) in the level frame.
        corners: (M, 2) of the room.
        faces: Its walls.

    Returns:
        (N,) their numbers, to two centimetres; -1 where none is within reach.
    """
    low = corners.min(axis=0) - REACH_M - _PLAN_CELL_M
    shape = np.ceil((corners.max(axis=0) + REACH_M - low) / _PLAN_CELL_M).astype(np.int64) + 1
    x, y = (
        start + _PLAN_CELL_M * (np.arange(n) + 0.5) for start, n in zip(low, shape, strict=True)
    )
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    best = np.full(shape, REACH_M)
    nearest = np.full(shape, -1, dtype=np.int16)
    for face in faces:
        along, out = (places - face.left) @ face.along, (places - face.left) @ face.outward
        away = np.hypot(np.maximum(np.maximum(-along, along - face.length), 0.0), out)
        closer = away < best
        best[closer], nearest[closer] = away[closer], face.number
    # Points beyond the map are clamped to its outermost cells, which are out of reach.
    cells = [
        np.clip((points[:, i] - low[i]) / _PLAN_CELL_M, 0, shape[i] - 1).astype(np.int64)
        for i in (0, 1)
    ]
    return np.asarray(nearest[cells[0], cells[1]])
