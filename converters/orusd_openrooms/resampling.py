"""Pictures at another resolution: the mean over the area of every new pixel."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def area_mean(pixels: NDArray[Any], rows: int, columns: int) -> NDArray[np.float32]:
    """Average a picture over the pixels of a coarser (or finer) grid that covers it.

    Args:
        pixels: (height, width, components).
        rows: Of the result.
        columns: Of the result.

    Returns:
        (rows, columns, components).
    """
    down = _overlaps(pixels.shape[0], rows)
    across = _overlaps(pixels.shape[1], columns)
    reduced = np.einsum("rh,hwc->rwc", down, pixels.astype(np.float64), optimize=True)
    result: NDArray[np.float32] = np.einsum("cw,rwk->rck", across, reduced, optimize=True).astype(
        np.float32
    )
    return result


def _overlaps(size: int, parts: int) -> NDArray[np.float64]:
    """(parts, size) which share of every part a cell covers; rows sum to 1."""
    edges = np.linspace(0.0, size, parts + 1)
    low, high = edges[:-1, None], edges[1:, None]
    cell = np.arange(size)
    covered = np.minimum(high, cell + 1) - np.maximum(low, cell)
    shares: NDArray[np.float64] = np.clip(covered, 0.0, None) / (high - low)
    return shares
