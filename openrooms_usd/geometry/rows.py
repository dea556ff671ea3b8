"""Rows of arrays that are there more than once."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]


def distinct_rows(rows: NDArray[Any]) -> tuple[Indices, Indices]:
    """The distinct rows of an array in lexicographic order, as `numpy.unique` has them, but faster.

    Args:
        rows: (N, K), K at least 1.

    Returns:
        (M,) where each distinct row comes first, and (N,) which of these each row is.
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    new = np.ones(len(rows), dtype=np.bool_)
    new[1:] = ordered[1:, 0] != ordered[:-1, 0]
    for column in ordered.T[1:]:
        new[1:] |= column[1:] != column[:-1]
    which = np.empty(len(rows), dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    return order[new], which
