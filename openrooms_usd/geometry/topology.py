"""How the faces of a mesh hang together: by places, by points and by edges; equal rows."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.mesh import Mesh


def weld(points: Array, tolerance: float) -> tuple[Ints, Ints]:
    """Which points are one.

    Those are that lie in one cell of a grid. It begins at their least coordinates: far from the
    origin it would be coarse.

    Args:
        points: (N, D) finite.
        tolerance: Width of a cell.

    Returns:
        (K,) the first point of each place, the places in the order of x, then y and so on; and
        (N,) the number of each point's place.
    """
    low = points.min(axis=0) if len(points) else 0.0
    return distinct_rows(np.round((points - low) / tolerance))


def connected(size: int, first: Ints, second: Ints) -> Ints:
    """(size,) the number of the component of each node of a graph, given the ends of its links.

    Roots of trees hang themselves below lower ones that they are linked to, until none is (Y.
    Shiloach and U. Vishkin, An O(log n) parallel connectivity algorithm, 1982).
    """
    root = np.arange(size)
    first, second = (np.asarray(ends, dtype=np.int64) for ends in (first, second))
    while True:
        first, second = root[first], root[second]
        apart = first != second
        if not apart.any():
            return np.unique(root, return_inverse=True)[1]
        first, second = first[apart], second[apart]
        np.minimum.at(root, np.maximum(first, second), np.minimum(first, second))
        while (above := root[root]).tobytes() != root.tobytes():
            root = above


def parts(triangles: Ints) -> Ints:
    """(M,) the number of the part that each of (M, 3) triangles is of, by the points they share."""
    starts, ends = triangles[:, [0, 0]].ravel(), triangles[:, [1, 2]].ravel()
    of_points = connected(int(triangles.max(initial=-1)) + 1, starts, ends)
    return np.unique(of_points[triangles[:, 0]], return_inverse=True)[1]


def directed_edges(triangles: Ints) -> Ints:
    """(3 M, 2) the edges of (M, 3) triangles as they run, three rows for each."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def open_edges(triangles: Ints) -> tuple[Ints, Ints, Ints]:
    """The edges that (M, 3) triangles do not run along equally often in both directions.

    Returns:
        (E,) a triangle that has the edge, (E,) where it starts and (E,) where it stops; once for
        each time that the other direction is missing.
    """
    ends = directed_edges(triangles)
    low, high = np.sort(ends, axis=1).T
    _, first, at = np.unique(low << 32 | high, return_index=True, return_inverse=True)
    signs = np.where(ends[:, 0] < ends[:, 1], 1, -1)
    net = np.bincount(at, signs, minlength=len(first)).astype(np.int64)
    rows, net = np.repeat(first, abs(net)), np.repeat(net, abs(net))
    starts = np.where(net > 0, low[rows], high[rows])
    return rows // 3, starts, np.where(net > 0, high[rows], low[rows])


def is_closed(mesh: Mesh) -> bool:
    """Whether every edge belongs to two faces that run along it in opposite directions.

    Edges are identified by the indices of their points: points at the same place must be shared.
    """
    ends = np.cumsum(mesh.counts)
    following = np.arange(len(mesh.indices)) + 1
    following[ends - 1] = ends - mesh.counts
    edges = np.stack([mesh.indices, mesh.indices[following]], axis=1).astype(np.int64)
    width = len(mesh.points)
    forward = np.sort(edges[:, 0] * width + edges[:, 1])
    backward = np.sort(edges[:, 1] * width + edges[:, 0])
    return bool((np.diff(forward) > 0).all() and np.array_equal(forward, backward))


def distinct_rows(rows: NDArray[Any]) -> tuple[Ints, Ints]:
    """The distinct rows of an array in lexicographic order, as `numpy.unique` has them, but faster.

    Args:
        rows: (N, K), K at least 1.

    Returns:
        (M,) where each distinct row comes first, and (N,) which of these each row is.
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    new = np.ones(len(rows), dtype=np.bool_)
    new[1:] = ordered[1:, 0] != ordered[:-1, 0]
    for column in ordered.T[1:]:
        new[1:] |= column[1:] != column[:-1]
    which = np.empty(len(rows), dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    return order[new], which
