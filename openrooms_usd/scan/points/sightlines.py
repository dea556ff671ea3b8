"""Which places the sensors of a scan look at without anything in between."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.visibility import likely_sensor_origins

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Voxels that hold points block sight; metres.
VOXEL: Final = 0.05
_MOST_SENSORS: Final = 24
# Sensors see surfaces up to this far, metres, and at this cosine of incidence or more.
_MAX_SIGHT_M: Final = 5.5
_MIN_INCIDENCE_COS: Final = 0.3
# A line of sight begins this far before the surface, so that its own returns do not block it.
_CLEAR_BEFORE_SURFACE_M: Final = 0.12
# Voxels with this part of the points of usual ones, or less, hold strays.
_STRAY_SHARE: Final = 0.15
_MAX_POINTS: Final = 100_000


@dataclass(frozen=True, eq=False)
class Sight:
    """What blocks the view in a scan.

    Attributes:
        sensor_origins: (V, 3) places far from each other where the scanner stood, or may have.
        low: (3,) the corner of the voxels.
        full: Which voxels block, one layer of free ones around them.
    """

    sensor_origins: Array
    low: Array
    full: Mask

    def sensors_looking_at(self, places: Array, outward: Array) -> NDArray[np.int64]:
        """(N,) how many sensors look at places of a surface with nothing in between.

        Args:
            places: (N, 3) metres.
            outward: (3,) unit vector from the side of the sensors through the surface.
        """
        seen = np.zeros(len(places), dtype=np.int64)
        for origin in self.sensor_origins:
            sight = origin - places
            distance = np.linalg.norm(sight, axis=1)
            facing = -(sight @ outward) > _MIN_INCIDENCE_COS * np.maximum(
                distance, _CLEAR_BEFORE_SURFACE_M
            )
            rows = np.flatnonzero(facing & (distance < _MAX_SIGHT_M))
            seen[rows[~self._blocked(places[rows], sight[rows] / distance[rows, None], outward,
                                     distance[rows])]] += 1  # fmt: skip
        return seen

    def _blocked(self, places: Array, toward: Array, outward: Array, distance: Array) -> Mask:
        blocked = np.zeros(len(places), dtype=np.bool_)
        start = _CLEAR_BEFORE_SURFACE_M / np.maximum(-(toward @ outward), 1e-9)
        last = np.array(self.full.shape) - 1
        open_rows = np.arange(len(places))
        for step in range(int(_MAX_SIGHT_M / VOXEL)):
            reached = start[open_rows] + step * VOXEL
            open_rows = open_rows[reached < distance[open_rows]]
            if not len(open_rows):
                break
            at = places[open_rows] + (start[open_rows] + step * VOXEL)[:, None] * toward[open_rows]
            cell = np.clip(((at - self.low) / VOXEL).astype(np.int64), 0, last)
            hit = self.full[cell[:, 0], cell[:, 1], cell[:, 2]]
            blocked[open_rows[hit]] = True
            open_rows = open_rows[~hit]
        return blocked


def sight_of(points: Array, sensor_origins: Array | None) -> Sight:
    """What blocks the view in a scan.

    Args:
        points: (N, 3) in the level frame, metres.
        sensor_origins: (V, 3) where the scanner stood; None: wherever somebody could have stood.
    """
    some = points[:: max(1, len(points) // _MAX_POINTS)]
    low, high = np.quantile(some, (0.001, 0.999), axis=0)
    low = low - 3 * VOXEL
    shape = tuple(np.ceil((high + 3 * VOXEL - low) / VOXEL).astype(np.int64).tolist())
    cells = np.clip((points - low) / VOXEL, 0, np.array(shape) - 1).astype(np.int64)
    flat = (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]
    counts = np.bincount(flat, minlength=shape[0] * shape[1] * shape[2]).reshape(shape)
    # What lies far outside was put into the outermost voxels.
    for axis in range(3):
        np.moveaxis(counts, axis, 0)[[0, -1]] = 0
    usual = float(np.median(counts[counts > 0]))
    stood = (
        likely_sensor_origins(points)
        if sensor_origins is None or not len(sensor_origins)
        else sensor_origins
    )
    chosen = np.unique(np.linspace(0, len(stood) - 1, _MOST_SENSORS).round().astype(np.int64))
    return Sight(stood[chosen], low, counts > _STRAY_SHARE * usual)
