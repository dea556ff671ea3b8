"""Repeats that fit: whole numbers of them, their phases, and jittered cells about their middles."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.arrays import Ints
from openrooms_usd.library.textures.base.family import TextureParams
from openrooms_usd.library.textures.base.maps import Maps
from openrooms_usd.library.textures.base.noise import Field, apart

# Nothing that repeats is drawn thinner than this many texels: it would only make a moiré.
_MIN_TEXELS: Final = 2.5
# Small pictures are drawn on a finer grid of up to so many texels, then averaged.
_FINE_GRID_TEXELS: Final = 512
# At least so many rows of texels are worked on at once.
_BLOCK_TEXELS: Final = 16


def whole(order: TextureParams, pitch: float, multiple: int = 1) -> int:
    """How many repeats of about ``pitch`` metres go on a side: rounded, so that they tile.

    At least ``multiple`` and a multiple of it. On grids too coarse for them they come fewer.
    """
    visible = max(pitch, _MIN_TEXELS * order.size / order.resolution)
    return multiple * max(1, round(order.size / visible / multiple))


def spacing(order: TextureParams, pitch: float, count: int) -> float:
    """Distance that relief is scaled by, metres: of ``count`` repeats, but not above ``pitch``."""
    return min(pitch, order.size / count)


def phase(resolution: int, count: int) -> Field:
    """(N,) place of texel centres, in repeats."""
    return (np.arange(resolution) + 0.5) / resolution * count


def wave(resolution: int, count: int, shift: float = 0.0) -> Field:
    """(N,) cosine of so many periods, crest at ``shift`` of a period."""
    return np.cos(2.0 * np.pi * (phase(resolution, count) - shift))


def offset(place: Field) -> Field:
    """-1..1 across each repeat of a phase, 0 in its middle."""
    return 2.0 * (place - np.floor(place)) - 1.0


def diagonal(resolution: int, columns: int, rows: int) -> tuple[Field, Field]:
    """(N, N) places across diamonds, in two slanted directions, in diamonds.

    There are two diamonds to each column and row: one in its middle, one about its corners.
    """
    across, along = phase(resolution, columns)[None], phase(resolution, rows)[:, None]
    return across + along, across - along


def resolved(
    make: Callable[[TextureParams], Maps], detail: float
) -> Callable[[TextureParams], Maps]:
    """A recipe whose small pictures are averages of larger ones, so that fine detail fades.

    Args:
        make: The recipe.
        detail: Size of the finest repeat, metres; three texels shall cover it.
    """

    def make_resolved(order: TextureParams) -> Maps:
        needed = 3.0 * order.size / detail / order.resolution
        finer = min(max(1, math.ceil(needed)), max(1, _FINE_GRID_TEXELS // order.resolution))
        maps = make(replace(order, resolution=order.resolution * finer))
        return Maps(
            averaged(maps.albedo, finer),
            averaged(maps.height, finer),
            averaged(maps.roughness, finer),
            maps.metallic,
        )

    return make_resolved


def averaged(field: Field, finer: int) -> Field:
    """Means over blocks of ``finer`` by ``finer``."""
    if finer == 1:
        return field
    n = len(field) // finer
    return np.asarray(field.reshape(n, finer, n, finer, *field.shape[2:]).mean(axis=(1, 3)))


@dataclass(frozen=True)
class LatticeCells:
    """Regions nearest to the jittered middles of a lattice. Lengths are in its pitches.

    Attributes:
        index: (N, N) which cell.
        count: How many there are.
        nearest: (N, N) distance to the cell's middle.
        border: (N, N) how much farther the next middle is: 0 on the border.
    """

    index: Ints
    count: int
    nearest: Field
    border: Field

    def dealt(self, rng: np.random.Generator, low: float, high: float) -> Field:
        """(N, N) a number for each cell, drawn from a range."""
        return np.asarray(apart(rng).uniform(low, high, self.count)[self.index])


def cells(
    rng: np.random.Generator,
    resolution: int,
    columns: int,
    rows: int,
    jitter: float,
    stagger: float = 0.0,
) -> LatticeCells:
    """Periodic cells (Worley, A Cellular Texture Basis Function, 1996).

    Args:
        rng: Where the middles come from.
        resolution: Texels along each side.
        columns: Cells along s.
        rows: Cells along t; even where staggered.
        jitter: How far middles stray, 0 (a lattice) to 1.
        stagger: How far every second row is moved, in columns.
    """
    stray = (apart(rng).random((2, rows, columns)) - 0.5) * jitter
    # Half to the left and half to the right: then the nine cells around hold the nearest two.
    moved = stagger * (np.arange(rows)[:, None] % 2 - 0.5)
    middle_s = np.arange(columns) + 0.5 + stray[0] + moved
    middle_t = np.arange(rows)[:, None] + 0.5 + stray[1]
    across, along = phase(resolution, columns), phase(resolution, rows)
    column, row = np.floor(across).astype(np.int64), np.floor(along).astype(np.int64)
    first = np.full((resolution, resolution), 99.0)
    second = first.copy()
    index = np.zeros((resolution, resolution), np.int64)
    # Some rows of cells at a time, so that the work stays in the processor's cache.
    together = math.ceil(_BLOCK_TEXELS * rows / resolution)
    ends = np.searchsorted(row, [*range(0, rows, together), rows]).tolist()
    for part in (slice(*pair) for pair in pairwise(ends)):
        near, far, which = first[part], second[part], index[part]
        # Texels in one row of cells have much in common, which is worked out once.
        lattice, at = np.unique(row[part], return_inverse=True)
        spread = slice(None) if len(lattice) == 1 else at
        for dj, di in np.ndindex(3, 3):
            jj, ii = lattice[:, None] + dj - 1, column + di - 1
            r, c = jj % rows, ii % columns
            s = (middle_s[r, c] + (ii - c) - across)[spread]
            t = (middle_t[r, c] + (jj - r))[spread]
            squared = s**2 + (t - along[part, None]) ** 2
            np.copyto(which, (r * columns + c)[spread], where=squared < near)
            np.minimum(far, np.maximum(near, squared), out=far)
            np.minimum(near, squared, out=near)
    nearest = np.sqrt(first)
    return LatticeCells(index, rows * columns, nearest, np.sqrt(second) - nearest)
