"""Mirrors on walls, which look like holes: the points behind them mirror the room.

Reflected at the wall, points seen through a mirror coincide with points inside the room; those of
a street or a corridor do not.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from openrooms_usd.scan.openings.cellcounts import CELL_M
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallfaces import WallFace
from openrooms_usd.scan.points.sightlines import VOXEL_M, Sight

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_MAX_POINTS: Final = 60_000
# Points nearer behind the wall may be of a frame, metres.
_FRAME_DEPTH_M: Final = 0.3
# Floors and ceilings of neighbouring rooms are coplanar, and left out with this margin, metres.
_FLOOR_MARGIN_M: Final = 0.15
# Least part of the reflected points that coincide with points, and their least number.
_MIN_REFLECTED_SHARE: Final = 0.6
_MIN_REFLECTED_RETURNS: Final = 12


@dataclass(frozen=True, eq=False)
class Echoes:
    """A scan prepared for the comparison of points behind walls with those inside.

    Attributes:
        points: (N, 3) a sample of the scan's points, in the level frame.
        full: Occupancy of the voxels of ``sight``, dilated by one.
        sight: Sensors and occlusion.
    """

    points: Array
    full: Mask
    sight: Sight

    def fill(self, face: WallFace, where: Rectangle) -> bool:
        """Whether the points seen through a rectangle of a wall mirror the room."""
        seen = self._through(face, where)
        if len(seen) < _MIN_REFLECTED_RETURNS:
            return False
        turned = face.to_level(seen * np.array([1.0, -1.0, 1.0]))
        last = np.array(self.full.shape) - 1
        cell = np.clip(((turned - self.sight.low) / VOXEL_M).astype(np.int64), 0, last)
        return bool(self.full[cell[:, 0], cell[:, 1], cell[:, 2]].mean() > _MIN_REFLECTED_SHARE)

    def _through(self, face: WallFace, where: Rectangle) -> Array:
        """(M, 3) points behind the wall that a sensor sees through a rectangle, in its frame."""
        points = face.from_level(self.points)
        points = points[(points[:, 1] > _FRAME_DEPTH_M) & (points[:, 2] > _FLOOR_MARGIN_M)]
        seen = np.zeros(len(points), dtype=np.bool_)
        for origin in face.from_level(self.sight.sensor_origins):
            if origin[1] < 0:
                share = (-origin[1] / (points[:, 1] - origin[1]))[:, None]
                x, z = (origin + share * (points - origin))[:, [0, 2]].T / CELL_M
                seen |= (x > where.left) & (x < where.right) & (z > where.bottom) & (z < where.top)
        return np.asarray(points[seen])


def echoes(points: Array, sight: Sight, height: float) -> Echoes:
    """Prepare a scan for the detection of mirrors.

    Args:
        points: (N, 3) of the scan, in the level frame.
        sight: Sensors and occlusion.
        height: Of the ceiling, metres.
    """
    some = points[:: max(1, len(points) // _MAX_POINTS)]
    low = some[some[:, 2] < height - _FLOOR_MARGIN_M]
    return Echoes(low, ndimage.binary_dilation(sight.full, np.ones((3, 3, 3), bool)), sight)
