"""Two independent halves of a picture, kept beside it in the memory of one more.

What is kept is by how much each differs from the picture, in parts of it: half precision tells that
to three digits, which is more than an estimated error has.
"""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats
from openrooms_usd.rendering.estimates import ErrorEstimate, Halves, estimate_of_ratio

_MOST_OF_HALF_PRECISION: Final = 65504.0
# Of larger pictures bands of rows are judged: whole tiles of hemispheres.
_MOST_JUDGED_PIXELS: Final = 1 << 19
_BAND_ROWS: Final = 16


@dataclass(frozen=True, eq=False)
class HalvedPicture:
    """A picture and its two halves, which fill up strip by strip.

    Attributes:
        pixels: (height, width, components).
        a: One half less the picture, in parts of it; nothing where the picture is 0.
        b: The other.
    """

    pixels: Floats
    a: NDArray[np.float16]
    b: NDArray[np.float16]

    @staticmethod
    def blank(pixels: Floats) -> "HalvedPicture":
        """A picture whose halves are like it, until they are filled in."""
        return HalvedPicture(pixels, *(np.zeros(pixels.shape, np.float16) for _ in range(2)))

    def fill(self, rows: slice, a: NDArray[Any], b: NDArray[Any]) -> None:
        """Fill in the halves of some rows."""
        pixels = self.pixels[rows]
        bright = pixels != 0.0
        for kept, half in ((self.a, a), (self.b, b)):
            part = np.subtract(half, pixels, dtype=np.float32)
            np.divide(part, pixels, out=part, where=bright)
            np.clip(part, -_MOST_OF_HALF_PRECISION, _MOST_OF_HALF_PRECISION, out=part)
            kept[rows] = np.where(bright, part, np.float32(0.0))

    def add(self, mean: NDArray[Any], a: NDArray[Any], b: NDArray[Any] | None = None) -> None:
        """Add to the picture and its halves; what would be negative becomes 0.

        Args:
            mean: To the picture.
            a: To one half.
            b: To the other; None: the same.
        """
        pixels = self.pixels.astype(np.float64)
        halves = pixels * (1.0 + self.a) + a, pixels * (1.0 + self.b) + (a if b is None else b)
        self.pixels[:] = np.maximum(pixels + mean, 0.0)
        self.fill(slice(None), *halves)

    def of(self, samples: tuple[int, int]) -> "KeptHalves":
        """The same, of so many samples each."""
        return KeptHalves(self.pixels, self.a, self.b, samples)


@dataclass(frozen=True, eq=False)
class KeptHalves:
    """The halves of a picture, as they are kept.

    Attributes:
        pixels: (height, width, components) the picture.
        a: As of `HalvedPicture`.
        b: As of `HalvedPicture`.
        samples: Samples a pixel in each half.
    """

    pixels: Floats
    a: NDArray[np.float16]
    b: NDArray[np.float16]
    samples: tuple[int, int]

    @staticmethod
    def made(pixels: Floats, halves: Halves) -> "KeptHalves":
        """What is kept of the halves of a picture."""
        kept = HalvedPicture.blank(pixels)
        kept.fill(slice(None), halves.a, halves.b)
        return kept.of(halves.samples)

    def rows(self, which: slice) -> "KeptHalves":
        """Some rows."""
        return KeptHalves(self.pixels[which], self.a[which], self.b[which], self.samples)

    @property
    def halves(self) -> Halves:
        """Both, as pictures."""
        pixels = self.pixels.astype(np.float64)
        return Halves(pixels * (1.0 + self.a), pixels * (1.0 + self.b), self.samples)

    @property
    def deviation(self) -> "Deviation":
        """The estimated standard error of the picture."""
        return Deviation(self)

    @property
    def estimate(self) -> ErrorEstimate:
        """The estimated errors of the picture; of a large one from bands of rows all over it."""
        height, width = self.pixels.shape[:2]
        bands = height // _BAND_ROWS
        step = height * width // _MOST_JUDGED_PIXELS
        if step < 2 or bands < 2 * step:
            return self.halves.estimate
        first = step // 2
        rows = np.concatenate(
            [np.arange(_BAND_ROWS) + band * _BAND_ROWS for band in range(first, bands, step)]
        )
        kept = KeptHalves(self.pixels[rows], self.a[rows], self.b[rows], self.samples)
        return kept.halves.estimate

    @property
    def estimate_of_ratio(self) -> ErrorEstimate:
        """The same where the picture is a ratio of two means."""
        halves = self.halves
        return estimate_of_ratio(self.pixels, halves.a, halves.b, *self.samples)


@dataclass(frozen=True, eq=False)
class Deviation:
    """The estimated standard error of a picture's pixels, computed by rows as they are asked for.

    Attributes:
        kept: What tells it.
    """

    kept: KeptHalves

    @property
    def shape(self) -> tuple[int, ...]:
        """Height, width, components."""
        return self.kept.pixels.shape

    def __getitem__(self, which: slice) -> Floats:
        return self.kept.rows(which).halves.deviation.astype(np.float32)
