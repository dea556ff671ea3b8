"""Windows hidden by curtains and blinds, which labels locate."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from openrooms_usd.scan.openings.cellcounts import CELL_M
from openrooms_usd.scan.openings.labelcounts import BLINDS, CURTAIN
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.walllabels import around
from openrooms_usd.scan.openings.wallpicture import WallGrid

Array = NDArray[np.float64]

# Margin of curtains around their window, horizontally and vertically, metres; a column of cells is
# hidden if this part of it is.
_CURTAIN_MARGINS_M: Final = (0.12, 0.1)
_HIDDEN_SHARE: Final = 0.3
# Curtains that end lower than this reach the floor, and the sill that is then assumed, metres.
_FLOOR_LENGTH_M: Final = 0.3
_HALF_SILL_M: Final = 0.5
# Largest width of a curtain that is drawn aside, metres.
_MAX_BUNDLE_WIDTH_M: Final = 0.6


def curtain_weights(grid: WallGrid) -> Array:
    """(Z, X) weights of curtains and blinds, by their labels."""
    curtain = around(grid.labels[CURTAIN] + grid.labels[BLINDS], grid.window)
    share = curtain / np.maximum(around(grid.labelled, grid.window), 1e-9)
    return np.asarray(np.where(curtain > 0, 2.0 * share - 1.0, np.where(grid.solid, -1.0, -0.2)))


def behind_curtain(where: Rectangle) -> Rectangle:
    """The likely window behind a curtain, which is a little larger.

    Behind one that reaches the floor may be a French window or a usual one: a sill at half the
    usual height overlaps most with either.
    """
    side, end = (round(length / CELL_M) for length in _CURTAIN_MARGINS_M)
    wide, tall = where.right - where.left > 4 * side, where.top - where.bottom > 4 * end
    bottom, top = where.bottom + end * tall, where.top - end * tall
    if where.bottom * CELL_M < _FLOOR_LENGTH_M:
        bottom = max(bottom, round(_HALF_SILL_M / CELL_M))
    return Rectangle(
        min(bottom, top - 1), top,
        where.left + side * wide, where.right - side * wide,
    )  # fmt: skip


def grown(where: Rectangle, more: float) -> Rectangle:
    """A rectangle widened on both sides, metres."""
    cells = round(more / CELL_M)
    return replace(where, left=max(where.left - cells, 0), right=where.right + cells)


def under_curtains(grid: WallGrid, where: Rectangle) -> Rectangle:
    """A window extended by its parts that curtains at its sides hide."""
    curtain = grid.labels[CURTAIN] + grid.labels[BLINDS]
    hidden = (curtain[where.rows] > 0).mean(axis=0) > _HIDDEN_SHARE
    left, right = _curtain_cells(hidden[: where.left][::-1]), _curtain_cells(hidden[where.right :])
    # A wide curtain beside a window that is open to the view belongs to another one.
    most = round(_MAX_BUNDLE_WIDTH_M / CELL_M)
    slit = where.right - where.left < most
    more = round(_CURTAIN_MARGINS_M[0] / CELL_M)
    left, right = (max(n - more, 0) if slit or n <= most else 0 for n in (left, right))
    return replace(where, left=where.left - left, right=where.right + right)


def _curtain_cells(hidden: NDArray[np.bool_]) -> int:
    """Cells of a curtain from the first one on, across gaps of up to two cells."""
    line = np.concatenate([[True] * 3, hidden, [False] * 3])
    gaps = np.flatnonzero(~ndimage.binary_closing(line, np.ones(3, dtype=bool))[3:])
    return int(gaps[0])
