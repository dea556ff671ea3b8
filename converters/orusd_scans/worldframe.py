"""The similarity transform from a source's frame to the world, and checks of matrices."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from orusd_scans.records import Node

# Y up to Z up: (x, y, z) -> (x, -z, y).
Z_UP: Final = {"Z": np.eye(3), "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])}
MAX_COORDINATE_M: Final = 1e8  # coordinates: any map projection stays below
# How far the axes of a rotation may be from unit length and right angles: rounding in text.
_ROTATION_TOLERANCE: Final = 1e-2
_BOTTOM: Final = np.array([0.0, 0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class WorldFrame:
    """world = unit * rotation (source - origin).

    Attributes:
        rotation: (3, 3) proper.
        origin: (3,) the source's point that becomes the world's origin, in the source's unit.
        unit: Metres for one unit of the source.
    """

    rotation: Array
    origin: Array
    unit: float = 1.0

    def points(self, source: Array) -> Array:
        """Points (..., 3) in the world, metres; the origin is subtracted first, for precision."""
        with np.errstate(invalid="ignore", over="ignore"):  # NaN is dropped later
            return np.asarray(self.unit * ((source - self.origin) @ self.rotation.T))

    def matrix(self, source_from_local: Array) -> Array:
        """(4, 4) from a local frame to the world, in metres."""
        M = np.eye(4)
        M[:3, :3] = self.unit * self.rotation @ source_from_local[:3, :3]
        M[:3, 3] = self.points(source_from_local[:3, 3])
        return M

    def pose(self, source_from_local: Array) -> Array:
        """(4, 4) rigid from a local frame that is in metres already, such as a camera's."""
        M = self.matrix(source_from_local)
        left, _, right = np.linalg.svd(M[:3, :3])
        M[:3, :3] = left @ right
        return M

    def source_from_world(self) -> Array:
        """(4, 4) the inverse transform, for column vectors."""
        M = np.eye(4)
        M[:3, :3], M[:3, 3] = self.rotation.T / self.unit, self.origin
        return M


def rigid(node: Node) -> Array:
    """A node's (4, 4) rotation with a translation: 12 or 16 numbers, row by row.

    Raises:
        InputError: It mirrors, scales or shears, or is column-major.
    """
    count = 12 if _length(node) == 12 else 16
    numbers = node.numbers(count, MAX_COORDINATE_M)
    rows = numbers.reshape(-1, 4)
    matrix = rows if count == 16 else np.vstack([rows, _BOTTOM])
    if np.abs(matrix[3] - _BOTTOM).max() > 1e-6:
        by_columns = np.abs(matrix[:, 3] - _BOTTOM).max() <= 1e-6
        raise node.error(
            "its translation is in the last row"
            if by_columns
            else "the last row of a transform is 0 0 0 1",
            "write the matrix row by row, with the translation in the last column",
        )
    proper(matrix[:3, :3], node)
    return np.asarray(matrix)


def proper(rotation: Array, node: Node) -> None:
    """Reject a (3, 3) matrix that is not a proper rotation.

    Raises:
        InputError: It mirrors, scales or shears.
    """
    if np.abs(rotation.T @ rotation - np.eye(3)).max() > _ROTATION_TOLERANCE:
        raise node.error("this is not a rotation: it scales or shears", "give orthonormal axes")
    if np.linalg.det(rotation) < 0.0:
        raise node.error("this is left-handed: it mirrors", "give the axes of a right-handed frame")


def _length(node: Node) -> int:
    rows = node.value if isinstance(node.value, list) else []
    return sum(len(row) if isinstance(row, list) else 1 for row in rows)
