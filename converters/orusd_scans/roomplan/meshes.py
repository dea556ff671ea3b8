"""The outline of a thin slab that is given as a triangle mesh."""

from collections import Counter
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Points nearer to each other than this are welded, metres: single precision in a room.
_WELD_M = 1e-5


def rim(points: Array, counts: NDArray[np.int64], indices: NDArray[np.int64]) -> Array | None:
    """The outer ring of the upper face of a slab; up is its thinnest axis.

    Args:
        points: (N, 3) the mesh's points, metres.
        counts: How many corners each face has.
        indices: The corners' points, face after face.

    Returns:
        (K, 3) the corners in order, or None when the upper face has no single simple ring.
    """
    if counts.sum() != len(indices) or counts.min() < 3 or not _within(indices, len(points)):
        return None
    axis = int(np.argmin(np.ptp(points, axis=0)))
    welded = np.unique(np.round(points / _WELD_M), axis=0, return_inverse=True)[1].ravel()
    upper = points[:, axis] > points[:, axis].max() - _WELD_M
    edges: Counter[tuple[int, int]] = Counter()
    for face in np.split(indices, np.cumsum(counts)[:-1]):
        if upper[face].all():
            ring = welded[face].tolist()
            edges.update(pairwise([*ring, ring[0]]))
    after = {a: b for a, b in edges if not edges[b, a] and a != b}
    ring = _ring(after)
    where = {int(w): i for i, w in reversed(list(enumerate(welded)))}
    return None if ring is None else points[[where[w] for w in ring]]


def _within(indices: NDArray[np.int64], count: int) -> bool:
    return bool(indices.min() >= 0 and indices.max() < count)


def _ring(after: dict[int, int]) -> list[int] | None:
    """The only cycle of a successor map; None when there is none, or several."""
    if len(after) < 3:
        return None
    start = min(after)
    ring, point = [start], after[start]
    while point != start and point in after and len(ring) <= len(after):
        ring.append(point)
        point = after[point]
    return ring if point == start and len(ring) == len(after) else None
