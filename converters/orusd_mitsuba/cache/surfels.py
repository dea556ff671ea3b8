"""Surfels: the surface elements that the light cache has a value for.

A surfel is what of one piece of surface lies in one cube of a grid and faces about one way, on one
side. A hash of the cube, the piece and the direction finds the surfel of a point (Binder, Fricke
and Keller 2019, "Massively parallel path space filtering"); surfels are kept in an open-addressing
table.

What arrives at the other side of sheets that pass light on has surfels of its own, of the points
that are seen from this side: those that are seen from the other one lie where more light arrives.
"""

from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Ints
from openrooms_usd.rendering.scene.arrays import Scene
from orusd_mitsuba.plugins.memory import aligned
from orusd_mitsuba.transport.light_index import registered

NEAREST_PER_SIZE: Final = 1.5
"""Rays shorter than this many edges of a surfel do not look it up."""

# Normals are rounded after this scaling: to the 26 neighbours of a cube.
_NORMAL_SCALE: Final = 1.2
# The grid is shifted by these parts of a cube, so that walls at whole metres do not lie between
# two of them.
_SHIFT_PARTS: Final = (0.371, 0.437, 0.419)
_LOAD: Final = 0.1
# Set in the piece of surfels that have what arrives at their other side.
_THROUGH: Final = 1 << 24
_MULTIPLIERS: Final = (0x8DA6B343, 0xD8163841, 0xCB1AB31F, 0x9E3779B1)


@dataclass(frozen=True, eq=False)
class SurfelTable:
    """Where surfels are found by their hashes.

    Attributes:
        size_m: Edge of a cube of the grid, metres.
        entries: (2^k, 2) uint32, the check of the surfel that lies there, 0 where none does, and
            its number.
        probes: So many entries from the hash on may hold it.
    """

    size_m: float
    entries: NDArray[np.uint32]
    probes: int


def tabulate(hashes: NDArray[np.uint32], size_m: float) -> tuple[SurfelTable, Ints]:
    """A table of all surfels that some points belong to.

    Args:
        hashes: (N, 2) of the points, from `SurfelIndex.hashes`.
        size_m: Edge of a cube of the grid, metres.

    Returns:
        The table, and (N,) the surfel of each point.
    """
    keys = hashes[:, 0].astype(np.uint64) << np.uint64(32) | hashes[:, 1].astype(np.uint64)
    distinct, numbers = np.unique(keys, return_inverse=True)
    slots = 1 << max(4, int(np.ceil(np.log2(max(1, len(distinct)) / _LOAD))))
    entries = np.zeros((slots, 2), dtype=np.uint32)
    waiting = np.arange(len(distinct))
    places = (distinct >> np.uint64(32)).astype(np.int64)
    checks = (distinct & np.uint64(0xFFFFFFFF)).astype(np.uint32)
    probes = 0
    while len(waiting):
        at = (places[waiting] + probes) & (slots - 1)
        _, first = np.unique(at, return_index=True)
        placed = first[entries[at[first], 0] == 0]
        entries[at[placed]] = np.column_stack([checks[waiting[placed]], waiting[placed]])
        waiting = np.delete(waiting, placed)
        probes += 1
    return SurfelTable(size_m, entries, max(1, probes)), numbers.astype(np.int64)


class SurfelIndex:
    """Finds the surfel of points of surfaces, for arrays of the active variant.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene, its shapes in the order of the scene's patches.
        size_m: Edge of a cube of the grid, metres.
        table: What is found in it; None where only hashes are wanted.
    """

    def __init__(
        self, scene: Scene, built: Any, size_m: float, table: SurfelTable | None = None
    ) -> None:
        self.size = dr.opaque(mi.Float, size_m)
        shapes = [int(registered(mi.ShapePtr(shape))[0]) for shape in built.shapes()]
        starts = np.zeros(max(shapes, default=0) + 1, dtype=np.uint32)
        starts[shapes] = scene.offsets[:-1]
        self._starts = mi.UInt32(aligned(starts))
        pieces = np.append(scene.triangles.pieces, 0).astype(np.uint32)
        self._pieces = mi.UInt32(aligned(pieces))
        if table is not None:
            self._entries = mi.UInt32(aligned(table.entries))
            self._mask = dr.opaque(mi.UInt32, len(table.entries) - 1)
            self._probes = table.probes

    def hashes(
        self, si: Any, towards: Any, active: Any = True, *, through: Any = False
    ) -> tuple[Any, Any]:
        """Place and check of the surfel that faces a direction.

        Args:
            si: Interactions on surfaces.
            towards: To the side that is meant.
            active: Where they are wanted.
            through: Whether the surfel is meant that has what arrives at its other side.
        """
        normal = mi.Vector3f(si.n) * dr.select(dr.dot(si.n, towards) >= 0.0, 1.0, -1.0)
        piece = self.piece(si, active)
        return self._hashes(si.p, normal, dr.select(through, piece | _THROUGH, piece))

    def piece(self, si: Any, active: Any = True) -> Any:
        """The piece of surface of interactions."""
        row = self.triangle(si.shape, si.prim_index, active & si.is_valid())
        return dr.gather(mi.UInt32, self._pieces, row, active & si.is_valid())

    def triangle(self, shape: Any, prim_index: Any, active: Any = True) -> Any:
        """Rows of the scene's triangles."""
        number: Any = dr.reinterpret_array(mi.UInt32, shape)
        return dr.gather(mi.UInt32, self._starts, number, active) + prim_index

    def _hashes(self, at: Any, normal: Any, piece: Any) -> tuple[Any, Any]:
        words: list[Any] = [
            dr.reinterpret_array(mi.UInt32, mi.Int32(dr.floor(at[k] / self.size + shift)))
            for k, shift in enumerate(_SHIFT_PARTS)
        ]
        faces = [mi.UInt32(mi.Int32(dr.round(normal[k] * _NORMAL_SCALE) + 1.0)) for k in range(3)]
        words.append(piece * 27 + faces[0] * 9 + faces[1] * 3 + faces[2])
        place: Any = mi.UInt32(0x2545F491)
        check: Any = mi.UInt32(0x9E3779B9)
        for word, multiplier in zip(words, _MULTIPLIERS, strict=True):
            place = _mixed((place ^ word) * multiplier)
            check = _mixed((check + word) * (multiplier ^ 0x5BD1E994))
        return place, check | 1

    def find(
        self, si: Any, towards: Any, active: Any = True, *, through: bool = False
    ) -> tuple[Any, Any]:
        """The number of the surfel that `hashes` belong to, and whether there is one."""
        return self._entry(*self.hashes(si, towards, active, through=through), active)

    def find_at(self, at: Any, normal: Any, piece: Any, active: Any = True) -> tuple[Any, Any]:
        """The same of a point of a piece, by the normal on the side that is meant."""
        return self._entry(*self._hashes(at, normal, piece), active)

    def _entry(self, place: Any, check: Any, active: Any) -> tuple[Any, Any]:
        found: Any = mi.Bool(False)
        number: Any = mi.UInt32(0)
        for step in range(self._probes):
            at = (place + step) & self._mask
            entry = dr.gather(mi.Vector2u, self._entries, at, active & ~found)
            here = active & ~found & (entry.x == check)
            number = dr.select(here, entry.y, number)
            found |= here
        return number, found


def _mixed(word: Any) -> Any:
    """A finalizer of Murmur hashes: every bit in changes half of the bits out."""
    word = (word ^ (word >> 16)) * 0x85EBCA6B
    word = (word ^ (word >> 13)) * 0xC2B2AE35
    return word ^ (word >> 16)
