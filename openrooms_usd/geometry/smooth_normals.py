"""Normals of polygons that meet smoothly, up to the edges that are sharp."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from openrooms_usd.geometry.cages import Cage

Array = NDArray[np.float64]


def smooth_normals(cage: Cage, points: Array) -> Array:
    """Means of the faces around each point, weighed by area.

    Args:
        cage: The polygons; edges of any sharpness are sharp.
        points: (N, 3) their points.

    Returns:
        (K, 3) unit normals at the corners.
    """
    at = points[cage.indices]
    sides = at[cage.after] - at, at[cage.before] - at
    own = np.cross(*sides)
    # Corners that share a point belong together where an edge between them is smooth.
    smooth = np.flatnonzero(cage.sharpness == 0.0)
    order = np.argsort(cage.edges, kind="stable")
    first = np.searchsorted(cage.edges[order], smooth)
    one, other = order[first], order[first + 1]
    # The two sides of an edge run against each other in a surface that has one outside.
    turned = cage.indices[one] == cage.indices[other]
    ends = np.where(turned, other, cage.after[other]), np.where(turned, cage.after[other], other)
    rows = np.concatenate([one, cage.after[one]])
    columns = np.concatenate(ends)
    count = len(cage.indices)
    joined = coo_array((np.ones(len(rows)), (rows, columns)), (count, count))
    _, group = connected_components(joined, directed=False)
    sums = np.stack([np.bincount(group, own[:, k]) for k in range(3)], axis=1)[group]
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    flat = np.divide(own, np.maximum(np.linalg.norm(own, axis=1, keepdims=True), 1e-300))
    return np.asarray(np.where(lengths > 0.0, sums / np.maximum(lengths, 1e-300), flat))
