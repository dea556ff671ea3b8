"""The front of carcass furniture cut into cells, and the measures that all fronts share."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

BOARD: Final = 0.018
GAP: Final = 0.003


# Between the back of a front and the carcass that it covers, metres.
SEAT: Final = 0.001
# How far handles stand out, metres.
HANDLE: Final = 0.028
Cell = tuple[float, float, float, float]
"""Left, right, lower and upper edge of an opening in the front, metres."""


def split(low: float, high: float, shares: Sequence[float]) -> list[tuple[float, float]]:
    """Cut a length into neighbouring pieces of the given shares."""
    edges = low + (high - low) * np.concatenate([[0.0], np.cumsum(shares) / np.sum(shares)])
    return [(float(a), float(b)) for a, b in pairwise(edges)]


def columns(cell: Cell, count: int) -> list[Cell]:
    """A cell cut into equal cells side by side."""
    return [(a, b, cell[2], cell[3]) for a, b in split(cell[0], cell[1], [1.0] * count)]


def rows(cell: Cell, shares: Sequence[float]) -> list[Cell]:
    """A cell cut into cells above each other, from below."""
    return [(cell[0], cell[1], a, b) for a, b in split(cell[2], cell[3], shares)]
