"""The place where most of a scan is, whatever its unit: without what was seen far outside.

Through a window or an open door a laser sees a street that is larger than the room, and stray
points lie anywhere. Both are thin: within the distance at which the room's points hold together,
they are single, or parts of their own.
"""

from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import evened


class Outside(NamedTuple):
    """What may lie outside.

    Attributes:
        percent: Of the points at most; the rest holds the room, and what is finer than that.
        longer: So many times as long as the room is a scan with it, or it is left alone.
    """

    percent: float
    longer: float


FEW: Final = Outside(20.0, 1.5)
"""As lasers see it: nearly all points are the room's."""
MOST: Final = Outside(75.0, 4.0)
"""After a scan was thinned evenly, as many programs do: a street has more surface than a room."""

# Places whose neighbours are looked at, and which neighbour; points hold together within so many
# times its distance.
_PLACES: Final = 4000
_NEIGHBOUR: Final = 30
_LINK: Final = 2.0
# Points of a cell count up to this multiple of the usual number; cells that touch are one part.
_MOST_COUNTED: Final = 5.0
_TOUCHING_CELLS: Final = 1.8
# Parts from this share of the largest one belong to it: rooms beside each other.
_PART_SHARE: Final = 0.25
# A scan without a part of this share has none that is the main one.
_MAIN_SHARE: Final = 0.6


def main_part(cloud: Cloud, outside: Outside = FEW) -> Cloud:
    """Points of the place where most of a scan is; all of a scan that is compact.

    Args:
        cloud: Finite points in any unit.
        outside: What may lie outside.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    some = cloud.take(evened(cloud)[0])
    if len(some) <= _NEIGHBOUR:
        return cloud
    # Squares of distances shall not overflow, whatever stands in a file.
    single = some.points / max(float(np.abs(some.points).max()), 1e-300)
    single -= np.median(single, axis=0)
    places = single[:: max(len(single) // _PLACES, 1)]
    away = np.asarray(KDTree(single).query(places, k=[_NEIGHBOUR])[0])
    link = _LINK * float(np.percentile(away, 100.0 - outside.percent))
    if not link > 0.0:
        return cloud
    cells, cell, counts = np.unique(
        np.floor(single / link), axis=0, return_inverse=True, return_counts=True
    )
    pairs = KDTree(cells).query_pairs(_TOUCHING_CELLS, output_type="ndarray")
    joined = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (len(cells),) * 2)
    part = connected_components(joined, directed=False)[1]
    cell = cell.reshape(-1)
    usual = float(np.percentile(counts[cell], outside.percent))
    # How many points are near each other: the room is dense, what is outside may have more.
    weight = np.bincount(part, np.minimum(counts, _MOST_COUNTED * usual) ** 2)
    main = weight >= _PART_SHARE * weight.max()
    inside = main[part[cell]]
    compact = _length(single) <= outside.longer * _length(single[inside])
    if compact or weight[main].sum() < _MAIN_SHARE * weight.sum():
        return cloud
    return some.take(inside)


def _length(points: Array) -> float:
    return float(np.ptp(points, axis=0).max())
