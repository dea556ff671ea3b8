"""Which triangles hang together, how they must be turned to agree, and what closes their holes."""

from dataclasses import dataclass

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.topology import connected, directed_edges, open_edges
from openrooms_usd.geometry.vectors import doubled_areas


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Pairs of triangles that share an edge.

    Attributes:
        first: (P,) triangles.
        second: (P,) triangles.
        manifold: (P,) whether no third triangle has that edge.
        against: (P,) whether both run along it in one direction: one of them is turned.
    """

    first: Ints
    second: Ints
    manifold: Mask
    against: Mask


@dataclass(frozen=True, eq=False)
class Lids:
    """Triangles that close the holes of components.

    Attributes:
        corners: (L, 3, 3) wound as their component is.
        labels: (L,) their components.
        openings: (K,) area of the holes of each component, m2.
    """

    corners: Array
    labels: Ints
    openings: Array


def neighbours(faces: Ints) -> Neighbours:
    """The pairs of (M, 3) triangles that share an edge."""
    ends, face = directed_edges(faces), np.repeat(np.arange(len(faces)), 3)
    forward = ends[:, 0] < ends[:, 1]
    low, high = np.sort(ends, axis=1).T
    keys = low << 32 | high
    order = np.argsort(keys, kind="stable")
    face, forward, same = face[order], forward[order], np.diff(keys[order]) == 0
    shared, at = np.concatenate([[False], same, [False]]), np.flatnonzero(same)
    return Neighbours(
        face[at], face[at + 1], ~shared[at] & ~shared[at + 2], forward[at] == forward[at + 1]
    )


def components(faces: Ints) -> tuple[Ints, Mask, Mask]:
    """Parts of a mesh that hang together by edges.

    Two copies of each triangle, as it is and turned, are joined where they agree along an edge. A
    component that can be wound alike falls into two copies; one that cannot, such as a Moebius
    strip, stays as it is.

    Returns:
        (M,) the component of each triangle, (M,) whether it must be turned to agree with the others
        of its component, and (K,) the components that have but one side.
    """
    pairs, count = neighbours(faces), len(faces)
    labels = connected(count, pairs.first, pairs.second)
    if not (pairs.against & pairs.manifold).any():
        return labels, np.zeros(count, dtype=np.bool_), np.zeros(labels.max() + 1, dtype=np.bool_)
    first, second, against = (
        array[pairs.manifold] for array in (pairs.first, pairs.second, pairs.against)
    )
    copies = connected(
        2 * count,
        np.concatenate([first, first + count]),
        np.concatenate([second + count * against, second + count * ~against]),
    )
    one_sided = np.bincount(labels, copies[:count] == copies[count:]) > 0
    return labels, _fewer(labels, copies[:count] > copies[count:]), one_sided


def lids(points: Array, faces: Ints, labels: Ints, count: int) -> Lids:
    """Fans that close the holes of ``count`` components.

    What edges are left without their opposite is a closed chain. Each connected piece of it is
    closed by a fan about its mean; that of a crack between triangles has no area.
    """
    # Components share no edges: that of an edge is that of any triangle that has it.
    rows, starts, stops = open_edges(faces)
    owners = labels[rows]
    if not len(owners):
        return Lids(np.zeros((0, 3, 3)), owners, np.zeros(count))
    ends = np.concatenate([owners * len(points) + starts, owners * len(points) + stops])
    nodes = np.unique(ends, return_inverse=True)[1]
    pieces = connected(int(nodes.max()) + 1, *nodes.reshape(2, -1))[nodes[: len(owners)]]
    loops = np.unique(pieces, return_inverse=True)[1]
    number = int(loops.max()) + 1
    means = _sums(loops, points[starts], number) / np.bincount(loops)[:, None]
    fans = np.stack([means[loops], points[stops], points[starts]], axis=1)
    areas = np.linalg.norm(_sums(loops, vector_areas(fans), number), axis=1)
    owner = np.zeros(number, dtype=np.int64)
    owner[loops] = owners
    return Lids(fans, owners, sums(owner, areas, count))


def sums(labels: Ints, values: Array, count: int) -> Array:
    """(count,) the sum of the values of each label."""
    return np.asarray(np.bincount(labels, values, minlength=count), dtype=np.float64)


def vector_areas(corners: Array) -> Array:
    """(M, 3) normals of (M, 3, 3) triangles that are as long as their areas, m2."""
    return 0.5 * doubled_areas(corners)


def _sums(labels: Ints, vectors: Array, count: int) -> Array:
    return np.stack([sums(labels, vectors[:, axis], count) for axis in range(3)], axis=1)


def _fewer(labels: Ints, turned: Mask) -> Mask:
    """The same choice or its opposite in each component: what turns the fewer triangles."""
    share = np.bincount(labels, turned) / np.bincount(labels)
    return np.asarray(turned ^ (share > 0.5)[labels])
