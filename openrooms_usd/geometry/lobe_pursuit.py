"""Spherical Gaussians chosen from a fixed set, one after the other, each where most light is left.

This is matching pursuit (S. Mallat, Z. Zhang, Matching Pursuits with Time-Frequency Dictionaries,
1993): what a lobe takes of the light is taken away before the next is chosen.
"""

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.geometry.hemisphere import HEMISPHERE

CELLS: Final = HEMISPHERE.directions.reshape(-1, 3).astype(np.float32)
MAX_SHARPNESS: Final = 128.0
"""A lobe of this sharpness is as wide as a cell; what is narrower falls between their middles."""

# What is smaller than e^-30 of a lobe's middle counts as that. Products of less are denormal
# numbers, on which processors spend a hundred times as long.
_MIN_LOGARITHM: Final = np.float32(-30.0)
# Sharpness, and how many cells lie from axis to axis.
_SHARPNESS_AND_CELLS: Final = ((1.0, 8), (4.0, 4), (16.0, 2), (MAX_SHARPNESS, 1))
# Cells, and lobes, in one matrix product: so few that it takes one thread.
_CELLS_AT_A_TIME: Final = 64


@dataclass(frozen=True, eq=False)
class _Set:
    """Lobes to choose from.

    Attributes:
        axes: (A, 3).
        sharpness: (A,).
        shapes: (A, cells) with the colour 1.
        pieces: (A / 64, cells / 64, 64, 64) the shapes in pieces, cells before lobes.
    """

    axes: Floats
    sharpness: Floats
    shapes: Floats
    pieces: Floats

    def products(self, values: Floats, power: int = 1) -> Floats:
        """(P, A) of (P, cells) with a power of the shapes."""
        cut = values.reshape(len(values), -1, _CELLS_AT_A_TIME).swapaxes(0, 1)
        found = (cut @ self.pieces**power).sum(axis=1)
        return np.asarray(found.swapaxes(0, 1).reshape(len(values), -1))


def pursue(light: Floats, weights: Floats, count: int) -> tuple[Floats, Floats]:
    """Choose lobes of the set.

    Args:
        light: (P, cells) to be made of lobes.
        weights: (P, cells) of squared differences.
        count: How many.

    Returns:
        (P, count, 3) axes and (P, count) sharpness.
    """
    known, points = _all_lobes(), np.arange(len(light))
    lengths = known.products(weights, 2)
    chosen = np.zeros((len(light), count), dtype=np.int64)
    left = light * weights
    for number in range(count):
        gain = known.products(left)
        share = gain / lengths
        best = np.argmax(np.maximum(gain, 0.0) * share, axis=1)
        left = left - share[points, best, None] * known.shapes[best] * weights
        chosen[:, number] = best
    return known.axes[chosen], known.sharpness[chosen]


def most_wanted(left: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """The lobe of the set that alone takes most of what is left.

    Args:
        left: (P, cells, C) of light, times the weights.
        weights: (P, cells) of squared differences.

    Returns:
        (P, 3) its axis and (P,) its sharpness.
    """
    known = _all_lobes()
    gains = sum(np.maximum(known.products(color), 0.0) ** 2 for color in np.moveaxis(left, -1, 0))
    best = np.argmax(gains / known.products(weights, 2), axis=1)
    return known.axes[best], known.sharpness[best]


def raised(logarithms: Floats, out: Floats | None = None) -> Floats:
    """Lobes of the colour 1 from their logarithms; none so small that products become denormal."""
    return np.asarray(np.exp(np.maximum(logarithms, _MIN_LOGARITHM, out=out), out=out))


@cache
def _all_lobes() -> _Set:
    """All lobes; the first of them again at the end, so that the last piece is whole."""
    lobes = [
        (sharpness, axis) for sharpness, step in _SHARPNESS_AND_CELLS for axis in _lattice(step)
    ]
    lobes += lobes[: -len(lobes) % _CELLS_AT_A_TIME]
    sharpness, axes = (np.array(values, np.float32) for values in zip(*lobes, strict=True))
    shapes = raised(sharpness[:, None] * (axes @ CELLS.T - 1.0))
    pieces = shapes.reshape(
        -1, _CELLS_AT_A_TIME, HEMISPHERE.count // _CELLS_AT_A_TIME, _CELLS_AT_A_TIME
    ).transpose(0, 2, 3, 1)
    return _Set(axes, sharpness, shapes, np.ascontiguousarray(pieces))


def _lattice(step: int) -> Array:
    """(A, 3) every so many rows, as many columns as leave axes no closer around than down."""
    found = []
    for row in range(step // 2, HEMISPHERE.rows, step):
        sine = np.hypot(*HEMISPHERE.directions[row, 0, :2])
        most = 4.0 * HEMISPHERE.rows * sine / step
        apart = HEMISPHERE.columns // 2 ** int(np.clip(np.log2(most), 1, 5))
        found.append(HEMISPHERE.directions[row, apart // 2 :: apart])
    return np.concatenate(found)
