"""The pixels around the horizon, finer than they are stored, painted from near to far.

So what is hidden is known before it is drawn, and costs nothing.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Mask
from openrooms_usd.library.surroundings.outside.noise import Floats

# Pixels of the canvas for one of the panorama, along each side: edges become soft.
_FINER: Final = 2
# So many rows of the panorama are worked on at once as processors keep near them.
_BLOCK_ROWS: Final = 8

Pixels = tuple[NDArray[np.intp], NDArray[np.intp]]
"""(K,) rows and (K,) columns of pixels in a patch."""


@dataclass(frozen=True, eq=False)
class Patch:
    """A rectangle of the canvas.

    Attributes:
        rows: Of the canvas.
        columns: Of the canvas.
        x: (1, W) of its ways, whose horizontal part has length 1.
        y: (1, W) of the same.
        z: (H, 1) of the same: the tangent of the elevation.
        step: Radians of a pixel.
    """

    rows: slice
    columns: slice
    x: Floats
    y: Floats
    z: Floats
    step: float


class Canvas:
    """Premultiplied colour and cover of a band around the horizon."""

    def __init__(self, height: int, lowest: float, highest: float) -> None:
        """Make it clear.

        Args:
            height: Rows of the whole panorama.
            lowest: Elevation of the band's lower edge, radians.
            highest: Of its upper edge.
        """
        self.step = math.pi / height / _FINER
        self.width = 2 * height * _FINER
        first = max(0, math.floor((0.5 * math.pi - highest) / math.pi * height))
        last = min(height, math.ceil((0.5 * math.pi - lowest) / math.pi * height))
        self.band = slice(first, last)
        count = (last - first) * _FINER
        elevation = 0.5 * math.pi - (first * _FINER + np.arange(count) + 0.5) * self.step
        longitude = math.pi - (np.arange(self.width) + 0.5) * self.step
        self._tangents = np.tan(elevation).astype(np.float32)
        self._elevations = elevation
        self._x = np.sin(longitude).astype(np.float32)
        self._y = -np.cos(longitude).astype(np.float32)
        self._color = np.zeros((count, self.width, 3), dtype=np.float32)
        # From zero, for which machines need no memory until something is painted.
        self._cover = np.zeros((count, self.width), dtype=np.float32)

    def around(self, points: Floats) -> Iterator[Patch]:
        """The patches that an outline covers, two where it goes across the seam.

        Args:
            points: (N, 3) around it, metres from the eye, near enough to each other.
        """
        longitude = np.unwrap(np.arctan2(points[:, 0], -points[:, 1]))
        elevation = np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))
        columns = (math.pi - longitude) / self.step
        left, right = math.floor(columns.min()) - 1, math.ceil(columns.max()) + 1
        first, last = np.searchsorted(
            -self._elevations, [-elevation.max() - self.step, -elevation.min() + self.step]
        )
        for turn in (-self.width, 0, self.width):
            low, high = max(left + turn, 0), min(right + turn, self.width)
            if low < high and first < last:
                yield self._patch(slice(int(first), int(last)), slice(low, high))

    def whole(self, lowest: float, highest: float) -> Patch:
        """All columns between two elevations, radians."""
        first, last = np.searchsorted(-self._elevations, [-highest, -lowest])
        return self._patch(slice(int(first), int(last)), slice(0, self.width))

    def _patch(self, rows: slice, columns: slice) -> Patch:
        return Patch(
            rows,
            columns,
            self._x[None, columns],
            self._y[None, columns],
            self._tangents[rows, None],
            self.step,
        )

    def seen(self, patch: Patch, inside: Mask) -> Pixels:
        """Those of (H, W) pixels where something behind what is there can be seen."""
        rows, columns = np.nonzero(inside & (self._cover[patch.rows, patch.columns] < 1.0))
        return rows, columns

    def paint(self, patch: Patch, pixels: Pixels, color: Floats, cover: Floats) -> None:
        """Put (K, 3) nits with (K,) cover behind what is there."""
        at = (pixels[0] + patch.rows.start) * self.width + (pixels[1] + patch.columns.start)
        there = self._cover.ravel()[at]
        added = (1.0 - there) * cover
        self._color.reshape(-1, 3)[at] += color * added[:, None]
        self._cover.ravel()[at] = there + added

    def over(self, panorama: Floats) -> None:
        """Put the band over a panorama (H, 2 H, 3), its painted rows."""
        width = self.width // _FINER
        painted = np.flatnonzero(self._cover.any(axis=1)) // _FINER
        for first in range(painted.min(), painted.max() + 1, _BLOCK_ROWS) if len(painted) else ():
            last = min(first + _BLOCK_ROWS, int(painted.max()) + 1)
            fine = slice(first * _FINER, last * _FINER)
            color = self._color[fine].reshape(last - first, _FINER, width, _FINER, 3)
            cover = self._cover[fine].reshape(last - first, _FINER, width, _FINER)
            # Sums of whole planes, which take a third of the time of a mean over two short axes.
            bright = color[:, 0, :, 0] + color[:, 0, :, 1] + color[:, 1, :, 0] + color[:, 1, :, 1]
            upper, lower = (cover[:, row, :, 0] + cover[:, row, :, 1] for row in range(_FINER))
            there = panorama[self.band][first:last]
            there *= 1.0 - (upper + lower)[..., None] / _FINER**2
            there += bright / _FINER**2
