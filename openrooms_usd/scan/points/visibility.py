"""Visibility of surfaces from the sensors, by range panoramas of the scan."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats, Mask

# Size of a panorama: a cell subtends two to three centimetres at two metres.
_PANORAMA_COLUMNS: Final = 512
_PANORAMA_ROWS: Final = 256
_MOST_SENSORS: Final = 20
# A surface is occluded by points nearer than it by more than this, metres plus share of its range.
_SEEN_MARGIN_M: Final = 0.03
_SEEN_MARGIN_SHARE: Final = 0.01
# Least cosine of incidence.
_GRAZING_COS: Final = 0.15
# Height above the floor at which people hold a scanner, their clearance, and the heights between
# which their bodies are.
_SENSOR_HEIGHT_M: Final = 1.5
_SENSOR_CLEARANCE_M: Final = 0.6
_BODY_HEIGHTS_M: Final = (0.3, 1.9)


@dataclass(frozen=True, eq=False)
class Panoramas:
    """Range images of a scan from some of its sensors, in all directions.

    Attributes:
        sensor_origins: (V, 3) metres.
        range: (V, rows * columns) metres; inf where there is no point.
    """

    sensor_origins: Array
    range: Floats

    def visible(self, points: Array, normals: Array, two_sided: Mask) -> Mask:
        """(N,) whether some sensor has an unoccluded view of surface points.

        That is, the range in their direction is finite and not well below their distance; a
        direction without any return proves nothing.

        Args:
            points: (N, 3) metres.
            normals: (N, 3) unit, outward.
            two_sided: (N,) whether the back may be seen too.
        """
        sight = self.sensor_origins[:, None] - points
        distance = np.sqrt(np.einsum("vij,vij->vi", sight, sight))
        cosine = np.einsum("vij,ij->vi", sight, normals) / np.maximum(distance, 1e-9)
        sensor, row = np.nonzero(np.where(two_sided, np.abs(cosine), cosine) > _GRAZING_COS)
        limit = self.range[sensor, _cells(-sight[sensor, row])]
        clear = distance[sensor, row] * (1.0 - _SEEN_MARGIN_SHARE) - _SEEN_MARGIN_M < limit
        seen = np.zeros(len(points), dtype=np.bool_)
        seen[row[clear & np.isfinite(limit)]] = True
        return seen


def look_around(points: Array, sensor_origins: Array) -> Panoramas:
    """The range panoramas of a scan.

    Args:
        points: (N, 3) metres.
        sensor_origins: (V, 3) metres; of many, a farthest-point sample is used.
    """
    chosen = sensor_origins[_far_apart(sensor_origins, _MOST_SENSORS)]
    nearest = np.full((len(chosen), _PANORAMA_ROWS * _PANORAMA_COLUMNS), np.inf, dtype=np.float32)
    for row, origin in zip(nearest, chosen, strict=True):
        sight = (points - origin).astype(np.float32)
        np.minimum.at(row, _cells(sight), np.sqrt(np.einsum("ij,ij->i", sight, sight)))
    return Panoramas(chosen, nearest)


def likely_sensor_origins(points: Array) -> Array:
    """(V, 3) likely sensor positions: over bare floor, clear of everything.

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
    """(N,) the panorama's cell of each direction (N, 3) of any length."""
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
