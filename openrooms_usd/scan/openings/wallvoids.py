"""Voids in a wall's picture: holes that somebody looked through, or what nobody looked at.

Who never looks up sees nothing of a wall's upper part, although nothing was in the way. So voids
are believed as far up as the wall was seen on both sides of them.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Mask = NDArray[np.bool_]

# Voids that are narrower are between things, cells of 2.5 cm.
_SLIT_CELLS: Final = 5
# Holes have wall on both sides within this distance, as high up as they go; where none is, nobody
# looked. Nor did they where nothing returned up to the top over more than a door's width. Cells.
_WALL_BESIDE_CELLS: Final = 60
_UNSEEN_CELLS: Final = 52


def enclosed(void: Mask, standing: Mask) -> Mask:
    """(Z, X) voids without slits, and without what nobody looked at above the wall that was seen.

    Args:
        void: (Z, X) where sensors looked through, as far as anything in their way is concerned.
        standing: (Z, X) where the wall returned.
    """
    broad = ndimage.binary_opening(void, np.ones((_SLIT_CELLS, _SLIT_CELLS), dtype=bool))
    pieces, count = ndimage.label(broad)
    over = np.isin(np.arange(count + 1), pieces[-_SLIT_CELLS:])[pieces] & broad
    unseen = ndimage.binary_opening(over, np.ones((1, _UNSEEN_CELLS), dtype=bool))
    rows = np.arange(len(void))[:, None]
    return np.asarray(broad & ~unseen & (~over | (rows < _horizon(standing))))


def _horizon(standing: Mask) -> NDArray[np.int64]:
    """(X,) up to which row the wall was seen on both sides of a column."""
    highest = np.where(standing.any(axis=0), len(standing) - standing[::-1].argmax(axis=0), 0)
    near = np.lib.stride_tricks.sliding_window_view(
        np.pad(highest, _WALL_BESIDE_CELLS), _WALL_BESIDE_CELLS + 1
    ).max(axis=1)
    return np.asarray(np.minimum(near[: len(highest)], near[_WALL_BESIDE_CELLS:]))
