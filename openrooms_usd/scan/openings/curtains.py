"""Windows behind curtains and blinds, where labels say that these hang there."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallholes import BLINDS, CURTAIN
from openrooms_usd.scan.openings.walllabels import around
from openrooms_usd.scan.openings.wallpicture import CELL, WallGrid

Array = NDArray[np.float64]

# Curtains reach beyond their window to the sides, and above and below, metres; a column of cells
# is behind one if this part of it is.
_CURTAIN_MORE: Final = (0.12, 0.1)
_VEILED_SHARE: Final = 0.3
# Curtains that end lower than this reach the floor, and where their windows' sills may be, metres.
_TO_THE_FLOOR: Final = 0.3
_MIN_SILL_SHARE: Final = 0.5
# Curtains that are drawn aside are up to this wide, metres.
_MAX_BUNDLE_WIDTH_M: Final = 0.6


def curtain_weights(grid: WallGrid) -> Array:
    """(Z, X) where curtains and blinds hang."""
    curtain = around(grid.labels[CURTAIN] + grid.labels[BLINDS])
    share = curtain / np.maximum(around(grid.labelled), 1e-9)
    return np.asarray(np.where(curtain > 0, 2.0 * share - 1.0, np.where(grid.solid, -1.0, -0.2)))


def behind_curtain(where: Rectangle) -> Rectangle:
    """Where a window probably is that a curtain hides: curtains are a little larger.

    Those that reach the floor hide French windows as well as usual ones: half the way up to a
    usual sill overlaps most with either.
    """
    side, end = (round(length / CELL) for length in _CURTAIN_MORE)
    wide, tall = where.right - where.left > 4 * side, where.top - where.bottom > 4 * end
    bottom, top = where.bottom + end * tall, where.top - end * tall
    if where.bottom * CELL < _TO_THE_FLOOR:
        bottom = max(bottom, round(_MIN_SILL_SHARE / CELL))
    return Rectangle(
        min(bottom, top - 1), top,
        where.left + side * wide, where.right - side * wide,
    )  # fmt: skip


def grown(where: Rectangle, more: float) -> Rectangle:
    """A rectangle that is larger to both sides, metres."""
    cells = round(more / CELL)
    return replace(where, left=max(where.left - cells, 0), right=where.right + cells)


def under_curtains(grid: WallGrid, where: Rectangle) -> Rectangle:
    """A window with those of its parts that curtains at its sides hide."""
    curtain = grid.labels[CURTAIN] + grid.labels[BLINDS]
    veiled = (curtain[where.rows] > 0).mean(axis=0) > _VEILED_SHARE
    left, right = _reach(veiled[: where.left][::-1]), _reach(veiled[where.right :])
    # A wide curtain beside a window that is open to the view belongs to another one.
    most = round(_MAX_BUNDLE_WIDTH_M / CELL)
    slit = where.right - where.left < most
    more = round(_CURTAIN_MORE[0] / CELL)
    left, right = (max(n - more, 0) if slit or n <= most else 0 for n in (left, right))
    return replace(where, left=where.left - left, right=where.right + right)


def _reach(veiled: NDArray[np.bool_]) -> int:
    """How far a curtain goes on from the first cell, gaps of two cells and less included."""
    line = np.concatenate([[True] * 3, veiled, [False] * 3])
    gaps = np.flatnonzero(~ndimage.binary_closing(line, np.ones(3, dtype=bool))[3:])
    return int(gaps[0])
