"""Triangles with what is known at their corners."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats, Mask

Ints = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Triangles:
    """Triangles with what is known at their corners.

    Attributes:
        corners: (M, 3, 3) world, metres; counter-clockwise seen from the front.
        normals: (M, 3, 3) unit shading normal at each corner.
        st: (M, 3, 2) texture coordinates at each corner.
        pieces: (M,) row of `Scene.pieces` that the triangle belongs to.
    """

    corners: Array
    normals: Floats
    st: Floats
    pieces: Ints

    def __len__(self) -> int:
        return len(self.corners)

    def rows(self, which: Any) -> "Triangles":
        """Some of the triangles, by an array of rows or of flags, or a slice."""
        return Triangles(
            self.corners[which], self.normals[which], self.st[which], self.pieces[which]
        )

    @property
    def parts(self) -> tuple["Triangles", ...]:
        """Plain triangles and instances, which these are one after the other."""
        return (self,)

    @property
    def landmarks(self) -> Array:
        """(N, 3) a corner of every triangle; of instances, one of each."""
        return self.corners[:, 0]

    @property
    def hull(self) -> Array:
        """(N, 3) points of the world; their hull holds all triangles."""
        return self.corners.reshape(-1, 3)

    def of_pieces(self, chosen: Mask) -> "Triangles":
        """Those that belong to some pieces, told by a flag for each row of `Scene.pieces`."""
        which = chosen[self.pieces]
        return self if which.all() else self.rows(which)

    def moved(self, motions: Mapping[int, Array]) -> "Triangles":
        """The same after a rigid motion (4, 4) of each of some pieces."""
        corners, normals = self.corners.copy(), self.normals.copy()
        for piece, motion in motions.items():
            which, R = self.pieces == piece, motion[:3, :3]
            corners[which] = corners[which] @ R.T + motion[:3, 3]
            normals[which] = (normals[which] @ R.T).astype(np.float32)
        return Triangles(corners, normals, self.st, self.pieces)

    @staticmethod
    def of(parts: Sequence["Triangles"]) -> "Triangles":
        """Plain triangles one after the other; those that `split` gave are not copied."""
        return Triangles(
            _joined(np.zeros((0, 3, 3)), [part.corners for part in parts]),
            _joined(np.zeros((0, 3, 3), np.float32), [part.normals for part in parts]),
            _joined(np.zeros((0, 3, 2), np.float32), [part.st for part in parts]),
            _joined(np.zeros(0, np.int32), [part.pieces for part in parts]),
        )

    def split(self, sizes: Sequence[int]) -> list["Triangles"]:
        """Slices of the given numbers of triangles, one after the other."""
        ends = np.cumsum([0, *sizes]).tolist()
        return [self.rows(slice(*some)) for some in pairwise(ends)]


def _joined(none: NDArray[Any], arrays: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Arrays one after the other; where they lie so in one array already, a view of that."""
    whole = arrays[0].base if arrays else None
    if whole is None or not whole.flags.c_contiguous or whole.shape[1:] != none.shape[1:]:
        return np.concatenate([none, *arrays])
    row = whole.strides[0]
    places = [one.ctypes.data - whole.ctypes.data for one in arrays]
    follow = [place + row * len(one) for place, one in zip(places, arrays, strict=True)]
    alike = all(one.base is whole and one.flags.c_contiguous for one in arrays)
    if not alike or whole.dtype != none.dtype or places[1:] != follow[:-1]:
        return np.concatenate([none, *arrays])
    return np.asarray(whole[places[0] // row : follow[-1] // row])
