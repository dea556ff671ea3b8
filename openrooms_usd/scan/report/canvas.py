"""Pictures of plans: dots, lines, dashes and words in metres, written as PNG."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import atomic, imagefile
from openrooms_usd.arrays import Array, Bytes, Ints
from openrooms_usd.lettering import Ink, lettered, stamp

Pixels = Bytes
Color = tuple[int, int, int]

PAPER: Final[Color] = (255, 255, 255)
# Of the typeface, pixels.
TEXT_PIXELS: Final = 20
# Paper around letters, pixels.
_RIM_PIXELS: Final = 2
# Where words go whose place is taken: half their width and their height aside, nearest first.
_STEPS_ASIDE: Final = sorted(
    ((right, down) for right in range(-3, 4) for down in range(-5, 6)),
    key=lambda step: (4 * abs(step[0]) + 2 * abs(step[1]), step),
)


@dataclass(frozen=True, eq=False)
class Canvas:
    """A picture of a plan, its y upwards.

    Attributes:
        pixels: (H, W, 3) sRGB, drawn upon.
        low: (2,) the plan's coordinates at the lower left corner, metres.
        scale: Pixels a metre.
        words: Left, top, right and bottom of what was written, which later words keep clear of.
    """

    pixels: Pixels
    low: Array
    scale: float
    words: list[tuple[int, int, int, int]] = field(default_factory=list)

    @classmethod
    def over(cls, low: Array, high: Array, most: int, finest: float) -> "Canvas":
        """An empty picture of a box (2,), (2,), of at most so many pixels a side and a metre."""
        side = float(max(*(high - low), 1e-3))
        scale = min(finest, most / side)
        width, height = (max(1, int(np.ceil(length * scale))) for length in high - low)
        return cls(np.full((height, width, 3), PAPER, np.uint8), np.asarray(low, float), scale)

    def place(self, points: Array) -> Array:
        """(N, 2) columns and rows of points of the plan, with fractions."""
        at = (points - self.low) * self.scale
        return np.column_stack([at[:, 0], len(self.pixels) - at[:, 1]])

    def counts(self, points: Array, grain: int = 1) -> Ints:
        """(H, W) how many points of the plan lie in each pixel's block of so many pixels a side."""
        height, width = self.pixels.shape[:2]
        rows, columns = -(-height // grain), -(-width // grain)
        column, row = np.floor(self.place(points) / grain).T.astype(np.int64)
        inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        flat = row[inside] * columns + column[inside]
        blocks = np.bincount(flat, minlength=rows * columns).reshape(rows, columns)
        return np.repeat(np.repeat(blocks, grain, axis=0), grain, axis=1)[:height, :width]

    def line(
        self,
        start: Array,
        end: Array,
        color: Color,
        width: float,
        dash: tuple[float, float] | None = None,
    ) -> None:
        """Draw a straight line of a width in pixels, dashed by lengths of ink and gap in pixels."""
        (x0, y0), (x1, y1) = self.place(np.array([start, end]))
        reach = width / 2 + 1
        left, right = self._span(min(x0, x1) - reach, max(x0, x1) + reach, 1)
        top, bottom = self._span(min(y0, y1) - reach, max(y0, y1) + reach, 0)
        if left >= right or top >= bottom:
            return
        x = np.arange(left, right)[None, :] + 0.5 - x0
        y = np.arange(top, bottom)[:, None] + 0.5 - y0
        length = max(float(np.hypot(x1 - x0, y1 - y0)), 1e-9)
        along = (x * (x1 - x0) + y * (y1 - y0)) / length
        beyond = np.maximum(np.maximum(-along, along - length), 0.0)
        away = np.hypot((y * (x1 - x0) - x * (y1 - y0)) / length, beyond)
        ink = np.clip(width / 2 + 0.5 - away, 0.0, 1.0)
        if dash:
            ink = ink * (np.mod(along, sum(dash)) < dash[0])
        part = self.pixels[top:bottom, left:right]
        part[:] = np.round(part + ink[..., None] * (np.array(color) - part.astype(np.float64)))

    def ring(self, corners: Array, color: Color, width: float) -> None:
        """Draw a closed ring of corners (N, 2)."""
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            self.line(start, end, color, width)

    def write(self, text: str, middle: Array, color: Color, size: int = TEXT_PIXELS) -> None:
        """Write words about a point of the plan or near it, with paper around the letters."""
        column, row = self.place(np.asarray(middle, float)[None])[0]
        ink = np.pad(lettered(text, size), _RIM_PIXELS)
        height, width = ink.shape
        left, top = self._clear_place(int(column) - width // 2, int(row) - height // 2, ink.shape)
        self.words.append((left, top, left + width, top + height))
        stamp(self.pixels, _swollen(ink), left, top, PAPER)
        stamp(self.pixels, ink, left, top, color)

    def _clear_place(self, left: int, top: int, shape: tuple[int, ...]) -> tuple[int, int]:
        """The nearest place for words where none are yet; the given one where there is none."""
        height, width = shape
        for right, down in _STEPS_ASIDE:
            x, y = left + right * width // 2, top + down * height
            if not any(
                x < other[2] and other[0] < x + width and y < other[3] and other[1] < y + height
                for other in self.words
            ):
                return x, y
        return left, top

    def _span(self, low: float, high: float, axis: int) -> tuple[int, int]:
        size = self.pixels.shape[axis]
        return int(np.clip(np.floor(low), 0, size)), int(np.clip(np.ceil(high), 0, size))


def _swollen(ink: Ink) -> Ink:
    from scipy import ndimage

    return np.asarray(
        ndimage.grey_dilation(ink, (2 * _RIM_PIXELS + 1, 2 * _RIM_PIXELS + 1)), dtype=np.float32
    )


def beside(pictures: Sequence[Pixels]) -> Pixels:
    """Pictures beside each other, on paper as high as the highest."""
    height = max(picture.shape[0] for picture in pictures)
    high = [
        np.pad(p, ((0, height - p.shape[0]), (0, 0), (0, 0)), constant_values=PAPER[0])
        for p in pictures
    ]
    return np.concatenate(high, axis=1)


def write_png(path: Path, pixels: Pixels) -> None:
    """Write a picture (H, W, 3); it appears whole or not at all.

    Raises:
        OutputError: The file cannot be written.
    """
    with atomic.replacing(path) as beside:
        imagefile.write_png(beside, pixels)
