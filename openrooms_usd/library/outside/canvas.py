"""The pixels around the horizon, finer than they are stored, painted from far to near."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.library.outside.noise import Floats

# Pixels of the canvas for one of the panorama, along each side: edges become soft.
_FINER: Final = 2


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
        self._clear = np.ones((count, self.width), dtype=np.float32)

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

    def paint(self, patch: Patch, color: Floats, cover: Floats) -> None:
        """Put (H, W, 3) nits with (H, W) cover over what is there."""
        there = self._color[patch.rows, patch.columns]
        clear = 1.0 - cover
        there *= clear[..., None]
        there += color * cover[..., None]
        self._clear[patch.rows, patch.columns] *= clear

    def over(self, panorama: Floats) -> None:
        """Put the band over a panorama (H, 2 H, 3)."""
        height, width = len(self._color) // _FINER, self.width // _FINER
        color = self._color.reshape(height, _FINER, width, _FINER, 3)
        clear = self._clear.reshape(height, _FINER, width, _FINER)
        # Sums of whole planes, which take a third of the time of a mean over two short axes.
        bright = color[:, 0, :, 0] + color[:, 0, :, 1] + color[:, 1, :, 0] + color[:, 1, :, 1]
        upper, lower = (clear[:, row, :, 0] + clear[:, row, :, 1] for row in range(_FINER))
        panorama[self.band] *= (upper + lower)[..., None] / _FINER**2
        panorama[self.band] += bright / _FINER**2
