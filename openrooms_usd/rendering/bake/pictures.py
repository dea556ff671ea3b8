"""From texels to pictures: what lies between charts is filled from beside it.

A bilinear look-up at the edge of a chart takes texels outside of it too; so each chart is given a
border of its own light. The same for every light, so that sums stay sums.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats, Ints, Mask
from openrooms_usd.rendering.bake.atlases import PADDING_TEXELS

Pixels = Floats

_AROUND: Final = tuple((x, y) for y in (-1, 0, 1) for x in (-1, 0, 1) if x or y)


class Border:
    """Fills the texels around those that are known, of pictures that know the same ones.

    Args:
        known: (height, width) which texels have a value.
        steps: How far the border reaches, texels.
    """

    def __init__(self, known: Mask, steps: int = PADDING_TEXELS) -> None:
        self._size = known.shape
        self._steps = []
        for _ in range(steps):
            neighbours = _shifted(known)
            new = ~known & neighbours.any(axis=0)
            self._steps.append((new, neighbours[:, new]))
            known = known | new

    def filled(self, pixels: Pixels) -> Pixels:
        """The picture, (height, width, 3), with its border; each texel is its neighbours' mean."""
        found = pixels.copy()
        for new, known in self._steps:
            around = _shifted(found)[:, new]
            total = np.where(known[..., None], around, 0.0).sum(axis=0, dtype=np.float64)
            found[new] = total / known.sum(axis=0)[:, None]
        return found


def _shifted(picture: NDArray[Any]) -> NDArray[Any]:
    """(8, height, width, ...) what stands beside each texel; 0 beyond the edges."""
    height, width = picture.shape[:2]
    padded = np.pad(picture, [(1, 1), (1, 1), *[(0, 0)] * (picture.ndim - 2)])
    return np.stack([padded[1 + y : 1 + y + height, 1 + x : 1 + x + width] for x, y in _AROUND])


def picture_of(size: tuple[int, int], column: Ints, row: Ints, values: Pixels) -> Pixels:
    """A picture with some texels set, the others 0.

    Args:
        size: Width and height.
        column: (T,) from the left.
        row: (T,) from the bottom.
        values: (T, 3).

    Returns:
        (height, width, 3), top row first.
    """
    found = np.zeros((size[1], size[0], 3), dtype=np.float32)
    found[size[1] - 1 - row, column] = values
    return found


def known_of(size: tuple[int, int], column: Ints, row: Ints) -> Mask:
    """(height, width) which texels `picture_of` sets."""
    found = np.zeros((size[1], size[0]), dtype=bool)
    found[size[1] - 1 - row, column] = True
    return found
