"""What of the plan is indoors, by the ceilings over it.

A ceiling that ends at walls nearly everywhere was scanned whole. What it does not cover is not
indoors: a yard seen through a gate, a corridor through a door. A ceiling that ends amid the room
was scanned in part, and says nothing about the rest.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.surfels import Surfels
from openrooms_usd.scan.rooms.occupancy import PIXEL_M, disc, plan_map

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_MIN_CEILING_M: Final = 1.9
# Least vertical component of a ceiling's normals, level or sloping.
_FACING_DOWN_COS: Final = 0.5
# Lamps, beams and gaps of a sparse scan in a ceiling are narrower, metres.
_GAP_M: Final = 0.6
_MIN_ROOF_M2: Final = 2.0
# A whole ceiling ends within this distance of walls along this part of its edge.
_BESIDE_WALL_M: Final = 0.35
_WHOLE_SHARE: Final = 0.85


def roofed(pieces: Surfels, barrier: Mask, low: Array) -> Mask:
    """(X, Y) what whole ceilings cover; all where the scan shows no whole one.

    Args:
        pieces: Surfels in the level frame.
        barrier: (X, Y) walls.
        low: (2,) the corner of pixel (0, 0), metres.
    """
    from scipy import ndimage

    above = (pieces.points[:, 2] > _MIN_CEILING_M) & (
        np.abs(pieces.normals[:, 2]) > _FACING_DOWN_COS
    )
    ceiling = plan_map(pieces.points[above, :2], low, barrier.shape) > 0
    radius = int(_GAP_M / 2.0 / PIXEL_M)
    closed = ndimage.binary_closing(np.pad(ceiling, radius), disc(radius))
    closed = ndimage.binary_fill_holes(closed)[radius:-radius, radius:-radius]
    closed &= ~barrier
    beside = ndimage.distance_transform_edt(~barrier) * PIXEL_M < _BESIDE_WALL_M
    groups, count = ndimage.label(closed)
    edge = closed & ~ndimage.binary_erosion(closed)
    size, rim, walled = (
        np.bincount(groups[mask], minlength=count + 1) for mask in (closed, edge, edge & beside)
    )
    large = size * PIXEL_M**2 > _MIN_ROOF_M2
    whole = large & (walled > _WHOLE_SHARE * rim)
    whole[0] = False
    if not whole.any():
        return np.ones(barrier.shape, bool)
    return np.asarray(whole[groups])
