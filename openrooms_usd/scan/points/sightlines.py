"""Lines of sight from the sensors of a scan to places, tested against an occupancy grid."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import ndimage

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.scan.points.visibility import likely_sensor_origins

# Edge of the voxels, metres; occupied ones occlude.
VOXEL_M: Final = 0.05
_MOST_SENSORS: Final = 24
# Greatest range of the sensors, metres, and least cosine of incidence.
_MAX_SIGHT_M: Final = 5.5
_MIN_INCIDENCE_COS: Final = 0.3
# A line of sight ends this far before the surface, whose own returns would occlude it.
_CLEAR_BEFORE_SURFACE_M: Final = 0.12
# Voxels with at most this part of the usual number of points hold outliers.
_STRAY_SHARE: Final = 0.15
_MAX_POINTS: Final = 100_000
# Surfaces with less points in a usual voxel have gaps.
_DENSE_COUNT: Final = 3.0


@dataclass(frozen=True, eq=False)
class Sight:
    """Sensors of a scan and the occupancy grid that occludes their views.

    Attributes:
        sensor_origins: (V, 3) positions of the sensor, known or likely, far from each other.
        low: (3,) least corner of the grid, metres.
        full: Occupancy of the voxels, with a layer of free ones around.
    """

    sensor_origins: Array
    low: Array
    full: Mask

    def sensors_looking_at(self, places: Array, outward: Array) -> Ints:
        """(N,) the number of sensors with an unoccluded line of sight to places on a surface.

        Args:
            places: (N, 3) metres.
            outward: (3,) unit normal of the surface, away from the sensors' side.
        """
        seen = np.zeros(len(places), dtype=np.int64)
        for origin in self.sensor_origins:
            sight = origin - places
            distance = np.linalg.norm(sight, axis=1)
            facing = -(sight @ outward) > _MIN_INCIDENCE_COS * np.maximum(
                distance, _CLEAR_BEFORE_SURFACE_M
            )
            rows = np.flatnonzero(facing & (distance < _MAX_SIGHT_M))
            seen[
                rows[
                    ~self._blocked(
                        places[rows], sight[rows] / distance[rows, None], outward, distance[rows]
                    )
                ]
            ] += 1
        return seen

    def _blocked(self, places: Array, toward: Array, outward: Array, distance: Array) -> Mask:
        blocked = np.zeros(len(places), dtype=np.bool_)
        start = _CLEAR_BEFORE_SURFACE_M / np.maximum(-(toward @ outward), 1e-9)
        last = np.array(self.full.shape) - 1
        open_rows = np.arange(len(places))
        for step in range(int(_MAX_SIGHT_M / VOXEL_M)):
            reached = start[open_rows] + step * VOXEL_M
            open_rows = open_rows[reached < distance[open_rows]]
            if not len(open_rows):
                break
            at = (
                places[open_rows] + (start[open_rows] + step * VOXEL_M)[:, None] * toward[open_rows]
            )
            cell = np.clip(((at - self.low) / VOXEL_M).astype(np.int64), 0, last)
            hit = self.full[cell[:, 0], cell[:, 1], cell[:, 2]]
            blocked[open_rows[hit]] = True
            open_rows = open_rows[~hit]
        return blocked


def sight_of(points: Array, sensor_origins: Array | None) -> Sight:
    """The occupancy grid of a scan and its sensors.

    Args:
        points: (N, 3) in the level frame, metres.
        sensor_origins: (V, 3); None: likely ones, over bare floor.
    """
    some = points[:: max(1, len(points) // _MAX_POINTS)]
    low, high = np.quantile(some, (0.001, 0.999), axis=0)
    low = low - 3 * VOXEL_M
    shape = tuple(np.ceil((high + 3 * VOXEL_M - low) / VOXEL_M).astype(np.int64).tolist())
    cells = np.clip((points - low) / VOXEL_M, 0, np.array(shape) - 1).astype(np.int64)
    flat = (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]
    counts = np.bincount(flat, minlength=shape[0] * shape[1] * shape[2]).reshape(shape)
    # Points far outside were clamped to the outermost voxels.
    for axis in range(3):
        np.moveaxis(counts, axis, 0)[[0, -1]] = 0
    usual = float(np.median(counts[counts > 0]))
    origins = (
        likely_sensor_origins(points)
        if sensor_origins is None or not len(sensor_origins)
        else sensor_origins
    )
    chosen = np.unique(np.linspace(0, len(origins) - 1, _MOST_SENSORS).round().astype(np.int64))
    full = counts > _STRAY_SHARE * usual
    if usual < _DENSE_COUNT:
        # Between the voxels of a sparse surface lines of sight would slip through.
        full |= ndimage.binary_closing(np.pad(full, 1), np.ones((3, 3, 3), bool))[1:-1, 1:-1, 1:-1]
    return Sight(origins[chosen], low, full)
