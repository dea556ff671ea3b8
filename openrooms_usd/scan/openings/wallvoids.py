"""Voids of a wall's evidence grid: holes, as opposed to areas that no sensor was pointed at.

A wall's upper part may lack returns because no sensor was tilted up. So a void counts up to the
height to which the wall was scanned on both its sides.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Mask = NDArray[np.bool_]

# Narrower voids are gaps between things; cells of 2.5 cm.
_SLIT_CELLS: Final = 5
# Holes have wall on both sides within this distance, up to their full height; voids to the top that
# are wider than a door were not scanned. Cells.
_WALL_BESIDE_CELLS: Final = 60
_UNSEEN_CELLS: Final = 52


def enclosed(void: Mask, standing: Mask) -> Mask:
    """(Z, X) voids without slits, and without unscanned areas above the wall's returns.

    Args:
        void: (Z, X) cells with unoccluded lines of sight and no return.
        standing: (Z, X) cells where the wall returned.
    """
    broad = ndimage.binary_opening(void, np.ones((_SLIT_CELLS, _SLIT_CELLS), dtype=bool))
    pieces, count = ndimage.label(broad)
    over = np.isin(np.arange(count + 1), pieces[-_SLIT_CELLS:])[pieces] & broad
    unseen = ndimage.binary_opening(over, np.ones((1, _UNSEEN_CELLS), dtype=bool))
    rows = np.arange(len(void))[:, None]
    return np.asarray(broad & ~unseen & (~over | (rows < _horizon(standing))))


def _horizon(standing: Mask) -> NDArray[np.int64]:
    """(X,) the row up to which the wall was scanned on both sides of a column."""
    highest = np.where(standing.any(axis=0), len(standing) - standing[::-1].argmax(axis=0), 0)
    near = np.lib.stride_tricks.sliding_window_view(
        np.pad(highest, _WALL_BESIDE_CELLS), _WALL_BESIDE_CELLS + 1
    ).max(axis=1)
    return np.asarray(np.minimum(near[: len(highest)], near[_WALL_BESIDE_CELLS:]))
