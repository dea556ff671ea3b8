"""What stands before a wall and what was seen beyond it, over the cells of its grid.

Behind furniture a wall shows nothing, whatever its picture looks like: a shelf is full of dark
recesses. Through a doorway or a clear pane, in contrast, the scan has returns farther out.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.openings.wallfaces import WallFace
from openrooms_usd.scan.points.sightlines import Sight

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Things before a wall: their distance from it, metres. Nearer are its own casings and sills.
_BEFORE_M: Final = (0.08, 0.75)
# Returns beyond a wall: behind its thickness, and within a scanner's reach, metres.
_BEYOND_M: Final = (0.6, 6.0)
# Blocks in which things before a wall (by the window of the grid), and views beyond it are marked,
# cells.
_BLOCKS_CELLS: Final = {3: 2, 5: 4, 7: 6, 9: 6}
_VIEW_CELLS: Final = 6
# Sensors nearer to the wall than this see it too flatly, metres.
_MIN_STAND_OFF_M: Final = 0.2
_MAX_POINTS: Final = 20_000


@dataclass(frozen=True, eq=False)
class WallViews:
    """The surroundings of a wall.

    Attributes:
        before: (Z, X) something stands before the wall.
        beyond: (Z, X) a line of sight to a return far behind the wall passes here.
    """

    before: Mask
    beyond: Mask


def wall_views(
    points: Array, face: WallFace, shape: tuple[int, int], cell: float, window: int, sight: Sight
) -> WallViews:
    """Look at what is before and beyond a wall.

    Args:
        points: (N, 3) of the whole scan, in the level frame, metres.
        face: The wall.
        shape: Rows and columns of its grid.
        cell: Their edge, metres.
        window: Cells that usually hold some returns.
        sight: Sensors.
    """
    x, y, z = face.from_level(points).T
    level = (z > cell) & (z < shape[0] * cell)
    near = level & (y < -_BEFORE_M[0]) & (y > -_BEFORE_M[1])
    before = _marked(x[near] / cell, z[near] / cell, shape, _BLOCKS_CELLS[window])
    far = np.flatnonzero(level & (y > _BEYOND_M[0]) & (y < _BEYOND_M[1]))
    far = far[:: max(1, len(far) // _MAX_POINTS)]
    beyond = np.zeros(shape, dtype=np.bool_)
    for ox, oy, oz in face.from_level(sight.sensor_origins):
        if oy < -_MIN_STAND_OFF_M:
            part = -oy / (y[far] - oy)
            at = ox + part * (x[far] - ox), oz + part * (z[far] - oz)
            beyond |= _marked(at[0] / cell, at[1] / cell, shape, _VIEW_CELLS)
    return WallViews(before, beyond)


def _marked(column: Array, row: Array, shape: tuple[int, int], block: int) -> Mask:
    """(Z, X) the blocks of cells that hold any of the places."""
    size = -(-shape[0] // block), -(-shape[1] // block)
    i, j = np.floor(row / block).astype(np.int64), np.floor(column / block).astype(np.int64)
    inside = (i >= 0) & (i < size[0]) & (j >= 0) & (j < size[1])
    marked = np.zeros(size, dtype=np.bool_)
    marked[i[inside], j[inside]] = True
    whole = np.repeat(np.repeat(marked, block, axis=0), block, axis=1)
    return whole[: shape[0], : shape[1]]
