"""Rectangles side by side on shelves: a simple way to pack them into a larger one."""

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


def shelved(sizes: Ints, width: int | None = None) -> tuple[Ints, tuple[int, int]]:
    """Pack rectangles, upright as they are: the highest first, each on the first shelf with room.

    (First fit by decreasing height: Coffman et al. 1980.)

    Args:
        sizes: (N, 2) width and height of each.
        width: Of the larger one; None: about as wide as high, and as the widest at least.

    Returns:
        (N, 2) lower left corner of each, and the width and height that all of them need.
    """
    if not len(sizes):
        return np.zeros((0, 2), np.int64), (0, 0)
    if width is None:
        width = max(int(np.ceil(np.sqrt(sizes.prod(axis=1).sum()))), int(sizes[:, 0].max()))
    corners = np.zeros((len(sizes), 2), dtype=np.int64)
    shelves: list[list[int]] = []  # where each begins, and how far it is full
    top = 0
    for row in np.lexsort((-sizes[:, 0], -sizes[:, 1])).tolist():
        across, high = sizes[row].tolist()
        shelf = next((one for one in shelves if one[1] + across <= width), None)
        if shelf is None:
            shelf = [top, 0]
            shelves.append(shelf)
            top += high
        corners[row] = shelf[1], shelf[0]
        shelf[1] += across
    return corners, (max(full for _, full in shelves), top)
