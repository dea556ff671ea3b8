"""Mirrors on walls: what seems to lie behind them is the room itself, turned over.

A mirror makes a hole in its wall as a window does. But the returns that come through it, reflected
at the wall, fall on what the scan shows inside the room; those of a street or a corridor do not.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallfaces import WallFace
from openrooms_usd.scan.openings.wallpicture import CELL
from openrooms_usd.scan.points.sightlines import VOXEL, Sight

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_MAX_POINTS: Final = 60_000
# What is nearer behind the wall is of its frame, metres.
_FRAME_DEPTH_M: Final = 0.3
# Floors and ceilings of any two rooms lie in one plane, so they say nothing, metres.
_FLOOR_MARGIN_M: Final = 0.15
# This part of the reflected returns must fall on something, of at least so many.
_MIN_REFLECTED_SHARE: Final = 0.6
_MIN_REFLECTED_RETURNS: Final = 12


@dataclass(frozen=True, eq=False)
class Echoes:
    """What a scan shows, to be compared with what it shows behind its walls.

    Attributes:
        points: (N, 3) some of the scan's points, in the level frame.
        full: The voxels of ``sight`` that hold points, or have a neighbour that does.
        sight: What the sensors could see.
    """

    points: Array
    full: Mask
    sight: Sight

    def fill(self, face: WallFace, where: Rectangle) -> bool:
        """Whether what is seen through a rectangle of a wall is the room itself."""
        seen = self._through(face, where)
        if len(seen) < _MIN_REFLECTED_RETURNS:
            return False
        turned = face.to_level(seen * np.array([1.0, -1.0, 1.0]))
        last = np.array(self.full.shape) - 1
        cell = np.clip(((turned - self.sight.low) / VOXEL).astype(np.int64), 0, last)
        return bool(self.full[cell[:, 0], cell[:, 1], cell[:, 2]].mean() > _MIN_REFLECTED_SHARE)

    def _through(self, face: WallFace, where: Rectangle) -> Array:
        """(M, 3) in the wall's frame, points behind it that a sensor sees through a place."""
        points = face.from_level(self.points)
        points = points[(points[:, 1] > _FRAME_DEPTH_M) & (points[:, 2] > _FLOOR_MARGIN_M)]
        seen = np.zeros(len(points), dtype=np.bool_)
        for origin in face.from_level(self.sight.sensor_origins):
            if origin[1] < 0:
                share = (-origin[1] / (points[:, 1] - origin[1]))[:, None]
                x, z = (origin + share * (points - origin))[:, [0, 2]].T / CELL
                seen |= (x > where.left) & (x < where.right) & (z > where.bottom) & (z < where.top)
        return np.asarray(points[seen])


def echoes(points: Array, sight: Sight, height: float) -> Echoes:
    """What is needed to tell mirrors from windows.

    Args:
        points: (N, 3) of the scan, in the level frame.
        sight: What its sensors could see.
        height: Of the ceiling, metres.
    """
    some = points[:: max(1, len(points) // _MAX_POINTS)]
    low = some[some[:, 2] < height - _FLOOR_MARGIN_M]
    return Echoes(low, ndimage.binary_dilation(sight.full, np.ones((3, 3, 3), bool)), sight)
