"""Returns counted over the cells of a wall, in windows as wide as the scan is sparse."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.int64]

CELL_M: Final = 0.025  # metres
# Cells with less than this part of the wall's usual number of returns are empty.
_EMPTY_CELL_SHARE: Final = 0.2
# Windows in which returns are counted, cells: the smallest that usually holds so many of them. A
# scan with returns every six centimetres shows nothing in cells of half of that.
WINDOWS_CELLS: Final = (3, 5, 7, 9)
_RETURNS_IN_WINDOW: Final = 4.0
_BLOCK_CELLS: Final = 10
# Radius of the local mean of returns, because density varies, metres.
_DENSITY_RADIUS_M: Final = 0.25
# Where the usual number of returns of a cell is less than this, the scan is sparse.
_MIN_USUAL_COUNT: Final = 0.5


def window_of(counts: Array) -> int:
    """The least window that usually holds some returns, where there are any."""
    rows, columns = (size // _BLOCK_CELLS * _BLOCK_CELLS for size in counts.shape)
    blocks = counts[:rows, :columns].reshape(
        rows // _BLOCK_CELLS, _BLOCK_CELLS, columns // _BLOCK_CELLS, _BLOCK_CELLS
    )
    returns = blocks.mean(axis=(1, 3))
    usual = float(np.median(returns[returns > 0])) if (returns > 0).any() else 1.0
    enough = (edge for edge in WINDOWS_CELLS if edge**2 * usual >= _RETURNS_IN_WINDOW)
    return next(enough, WINDOWS_CELLS[-1])


def layers_of(layers: Sequence[Array], window: int) -> tuple[Mask, Mask, Mask]:
    """Masks: the face returned; only surfaces behind it; only surfaces before it.

    Args:
        layers: (Z, X) returns on the face, behind it and before it.
        window: Edge of the windows in which they are counted, cells.
    """
    on, behind, before = (
        ndimage.uniform_filter(counts, window, mode="nearest") for counts in layers
    )
    usual = usual_counts(layers[0], on)
    present = on + behind > _EMPTY_CELL_SHARE * usual
    solid = present & ((on > behind) | (on > 0.5 * usual))
    return solid, present & ~solid, ~present & (before > _EMPTY_CELL_SHARE * usual)


def usual_counts(counts: Array, smooth: Array) -> Array:
    """Local mean of returns over the cells that have any.

    Args:
        counts: (Z, X) returns of each cell.
        smooth: (Z, X) their means over neighbours.
    """
    some = counts > 0
    if not some.any():
        return np.ones(counts.shape)
    total, cells = (
        ndimage.gaussian_filter(part, _DENSITY_RADIUS_M / CELL_M, mode="nearest")
        for part in (counts, some.astype(np.float64))
    )
    here = total / np.maximum(cells, 1e-3)
    middle = float(np.median(smooth[some]))
    least = min(_MIN_USUAL_COUNT, middle)
    return np.asarray(np.clip(here, least, max(least, middle)))


def cell_means(cells: Rows, values: Array, shape: tuple[int, int], window: int) -> Array:
    """(Z, X) means of values over windows around each cell; NaN without returns."""
    counts = counted(cells, shape)
    total = np.bincount(cells, values, shape[0] * shape[1]).reshape(shape).astype(np.float64)
    counts, total = (
        ndimage.uniform_filter(part, window, mode="constant") for part in (counts, total)
    )
    known = counts > 0.5 / window**2
    return np.where(known, total / np.where(known, counts, 1.0), np.nan)


def cells_of(x: Array, z: Array, shape: tuple[int, int]) -> Rows:
    """(N,) the cell of each place on a wall, in rows from the floor."""
    row = np.clip((z / CELL_M).astype(np.int64), 0, shape[0] - 1)
    return row * shape[1] + np.clip((x / CELL_M).astype(np.int64), 0, shape[1] - 1)


def counted(cells: Rows, shape: tuple[int, int]) -> Array:
    """(Z, X) the returns of each cell."""
    return np.bincount(cells, minlength=shape[0] * shape[1]).reshape(shape).astype(np.float64)
