"""The polygons of a subdivision surface: who is beside whom, and how sharp edges and points are."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from openrooms_usd.arrays import Array, Ints, Mask

Weights = csr_array


@dataclass(frozen=True, eq=False)
class Cage:
    """Polygons, and how sharp they are.

    Attributes:
        counts: (F,) corners of each face, at least three.
        indices: (K,) point of each corner.
        creases: (K,) sharpness of the edge from each corner to the next of its face; 0 is smooth.
        corners: (N,) sharpness of each point.
    """

    counts: Ints
    indices: Ints
    creases: Array
    corners: Array

    @cached_property
    def faces(self) -> Ints:
        """(K,) the face of each corner."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    @cached_property
    def after(self) -> Ints:
        """(K,) the next corner of the same face."""
        rows = np.arange(len(self.indices))
        ends = np.cumsum(self.counts)
        return np.where(rows + 1 == ends[self.faces], (ends - self.counts)[self.faces], rows + 1)

    @cached_property
    def before(self) -> Ints:
        """(K,) the corner before it."""
        found = np.empty_like(self.after)
        found[self.after] = np.arange(len(found))
        return found

    @cached_property
    def _unique(self) -> tuple[Ints, Ints, Ints]:
        pairs = np.sort(np.stack([self.indices, self.indices[self.after]], axis=1), axis=1)
        keys = pairs[:, 0] * (len(self.corners) + 1) + pairs[:, 1]
        _, first, edges, uses = np.unique(
            keys, return_index=True, return_inverse=True, return_counts=True
        )
        return pairs[first], edges.reshape(-1), uses

    @property
    def ends(self) -> Ints:
        """(E, 2) the points of each edge."""
        return self._unique[0]

    @property
    def edges(self) -> Ints:
        """(K,) the edge from each corner to the next."""
        return self._unique[1]

    @cached_property
    def sharpness(self) -> Array:
        """(E,) of each edge; of those that are not between two faces infinite."""
        found = np.zeros(len(self.ends))
        np.maximum.at(found, self.edges, self.creases)
        return np.where(self.is_open, np.inf, found)

    @property
    def is_open(self) -> Mask:
        """(E,) whether an edge is not between two faces."""
        return np.asarray(self._unique[2] != 2)

    # Who is beside whom, as matrices.

    @cached_property
    def middles(self) -> Weights:
        """(E, N) of each edge's middle."""
        rows = np.repeat(np.arange(len(self.ends)), 2)
        return matrix(rows, self.ends.reshape(-1), 0.5, (len(self.ends), len(self.corners)))

    @cached_property
    def centers(self) -> Weights:
        """(F, N) of each face's centre."""
        shape = len(self.counts), len(self.corners)
        return matrix(self.faces, self.indices, 1.0 / self.counts[self.faces], shape)

    @cached_property
    def edges_of_points(self) -> Weights:
        """(N, E) one for each edge that a point ends."""
        return csr_array((self.middles.T > 0).astype(np.float64))

    @cached_property
    def faces_of_points(self) -> Weights:
        """(N, F) one for each corner of a face."""
        shape = len(self.corners), len(self.counts)
        return matrix(self.indices, self.faces, 1.0, shape)

    @cached_property
    def faces_of_edges(self) -> Weights:
        """(E, F) one for each side of a face."""
        return matrix(self.edges, self.faces, 1.0, (len(self.ends), len(self.counts)))


def matrix(rows: Ints, columns: Ints, values: Array | float, shape: tuple[int, int]) -> Weights:
    """A sparse matrix; values of the same place are added."""
    return csr_array((np.broadcast_to(values, rows.shape), (rows, columns)), shape)
