"""What the scanner saw: how far it could look in every direction from where it stood."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Cells of a panorama: about the angle of two centimetres in two metres.
_PANORAMA_COLUMNS: Final = 512
_PANORAMA_ROWS: Final = 256
_MOST_SENSORS: Final = 20
# A surface is seen if nothing lies nearer to the sensor than this much before it, metres and share.
_SEEN_MARGIN_M: Final = 0.03
_SEEN_MARGIN_SHARE: Final = 0.01
# Cosine between line of sight and normal below which scanners see nothing.
_GRAZING_COS: Final = 0.15
# Where people hold a scanner, metres above the floor, and how far from anything, metres.
_SENSOR_HEIGHT_M: Final = 1.5
_SENSOR_CLEARANCE_M: Final = 0.6
_BODY_HEIGHTS_M: Final = (0.3, 1.9)


@dataclass(frozen=True, eq=False)
class Panoramas:
    """The nearest point of a scan in every direction from some sensors.

    Attributes:
        sensor_origins: (V, 3) metres.
        range: (V, rows * columns) metres; inf where there is no point.
    """

    sensor_origins: Array
    range: NDArray[np.float32]

    def visible(
        self, points: Array, normals: Array, two_sided: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """(N,) whether a scanner would have seen a surface there.

        It would if from one sensor the scan has a point behind it or about as far, and none well
        before it; where the scan has nothing at all in that direction, nothing is known.

        Args:
            points: (N, 3) metres.
            normals: (N, 3) unit, outward.
            two_sided: (N,) whether the other side may be seen too.
        """
        seen = np.zeros(len(points), dtype=np.bool_)
        for origin, nearest in zip(self.sensor_origins, self.range, strict=True):
            sight = origin - points
            distance = np.sqrt(np.einsum("ij,ij->i", sight, sight))
            cosine = np.einsum("ij,ij->i", sight, normals) / np.maximum(distance, 1e-9)
            facing = np.where(two_sided, np.abs(cosine), cosine) > _GRAZING_COS
            limit = nearest[_cells(-sight)]
            clear = distance * (1.0 - _SEEN_MARGIN_SHARE) - _SEEN_MARGIN_M < limit
            seen |= facing & clear & np.isfinite(limit)
        return seen


def look_around(points: Array, sensor_origins: Array) -> Panoramas:
    """What a scan shows from some of the places where the scanner stood.

    Args:
        points: (N, 3) metres.
        sensor_origins: (V, 3) metres; of many, those far from each other are taken.
    """
    chosen = sensor_origins[_far_apart(sensor_origins, _MOST_SENSORS)]
    nearest = np.full((len(chosen), _PANORAMA_ROWS * _PANORAMA_COLUMNS), np.inf, dtype=np.float32)
    for row, origin in zip(nearest, chosen, strict=True):
        sight = (points - origin).astype(np.float32)
        np.minimum.at(row, _cells(sight), np.sqrt(np.einsum("ij,ij->i", sight, sight)))
    return Panoramas(chosen, nearest)


def likely_sensor_origins(points: Array) -> Array:
    """(V, 3) where somebody could have stood: over bare floor, clear of everything.

    Args:
        points: (N, 3) metres, floor at z = 0.
    """
    cells = np.floor(points[:, :2] / _SENSOR_CLEARANCE_M).astype(np.int64)
    z = points[:, 2]
    bare, counts = np.unique(cells[np.abs(z) < 0.05], axis=0, return_counts=True)
    bare = bare[counts > 0.2 * np.median(counts)] if len(bare) else bare
    full = {
        tuple(cell) for cell in cells[(z > _BODY_HEIGHTS_M[0]) & (z < _BODY_HEIGHTS_M[1])].tolist()
    }
    free = [cell for cell in bare.tolist() if tuple(cell) not in full]
    chosen = np.array(free or bare.tolist() or [[0, 0]], dtype=np.float64)
    return np.column_stack(
        [(chosen + 0.5) * _SENSOR_CLEARANCE_M, np.full(len(chosen), _SENSOR_HEIGHT_M)]
    )


def _cells(sight: NDArray[np.floating]) -> NDArray[np.intp]:
    """The cell of a panorama in which directions of any length lie."""
    x, y, z = sight.astype(np.float32).T
    column = (
        np.arctan2(y, x) * np.float32(_PANORAMA_COLUMNS / (2.0 * np.pi)) + _PANORAMA_COLUMNS / 2
    ).astype(np.intp)
    height = np.arctan2(z, np.sqrt(x * x + y * y))
    row = (height * np.float32(_PANORAMA_ROWS / np.pi) + _PANORAMA_ROWS / 2).astype(np.intp)
    cell = np.minimum(row, _PANORAMA_ROWS - 1) * _PANORAMA_COLUMNS + np.minimum(
        column, _PANORAMA_COLUMNS - 1
    )
    return np.asarray(cell, dtype=np.intp)


def _far_apart(points: Array, count: int) -> NDArray[np.intp]:
    """Farthest-point sampling from the first point."""
    rows = [0]
    distance = np.linalg.norm(points - points[0], axis=1)
    while len(rows) < min(count, len(points)):
        rows.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(points - points[rows[-1]], axis=1))
    return np.array(rows, dtype=np.intp)
