"""What frames know of light is added up along a path: each surface keeps what was found of it.

The radiance of a frame is divided by the base colour, so that textures stay sharp, and mixed with
what earlier frames found at the same places of the same surfaces (`reprojection`). A mirror image
moves otherwise than the mirror: history that is far from what a pixel's neighbours show now is
drawn towards them (K. Karis, High quality temporal supersampling, SIGGRAPH 2014; the mean and
deviation of the neighbourhood after M. Salvi, GDC 2016). Both halves of the samples are carried
along alike, so that their difference tells the error of what comes out.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.rendering.estimates import Halves
from openrooms_usd.rendering.paths.reprojection import Taps

Pixels = NDArray[np.float32]

# Frames after which what is older counts no more than what is new.
LONGEST_HISTORY_FRAMES: Final = 32.0
_CLAMP_DEVIATIONS: Final = 2.0
_NEIGHBOURS_PIXELS: Final = 3  # to each side
# Of black surfaces what is scattered is no light per base colour.
_LEAST_BASE_COLOR: Final = 0.04


class Accumulation:
    """The light of the surfaces of the last frame.

    Args:
        longest: Frames that history counts at most.
    """

    def __init__(self, longest: float = LONGEST_HISTORY_FRAMES) -> None:
        self._longest = longest
        self._halves: list[Pixels] = []
        self._frames: Pixels = np.zeros(0, np.float32)

    def add(
        self, halves: Halves, base_color: Pixels, taps: Taps | None, frames: float = 1
    ) -> Halves:
        """Add a frame.

        Args:
            halves: Two independent estimates of its radiance, (H, W, 3).
            base_color: (H, W, 3).
            taps: Where its surfaces were in the last frame; None for the first.
            frames: How many frames' samples it has.

        Returns:
            The halves of the radiance with what is known from before.
        """
        shape = base_color.shape
        divisor = divisor_of(base_color).reshape(-1, 3)
        now: list[Pixels] = [
            np.asarray(half.reshape(-1, 3) / divisor, dtype=np.float32)
            for half in (halves.a, halves.b)
        ]
        if taps is None:
            self._halves, self._frames = now, np.full(len(divisor), frames, np.float32)
        else:
            known = np.where(taps.found, taps(self._frames), np.float32(0.0))
            known = np.minimum(known, np.float32(self._longest - frames))
            before = _near([taps(half) for half in self._halves], now, shape[:2])
            share = (np.float32(frames) / (known + np.float32(frames)))[:, None]
            self._halves = [
                np.asarray(old + share * (new - old), dtype=np.float32)
                for old, new in zip(before, now, strict=True)
            ]
            self._frames = known + np.float32(frames)
        a, b = ((half * divisor).reshape(shape) for half in self._halves)
        return Halves(a, b, halves.samples)


def divisor_of(base_color: Pixels) -> Pixels:
    """(..., 3) what light is divided by, so that textures stay out of what is added up."""
    return np.maximum(base_color, np.float32(_LEAST_BASE_COLOR))


def _near(before: list[Pixels], now: list[Pixels], shape: tuple[int, int]) -> list[Pixels]:
    """History that is no farther than the neighbourhood of a pixel allows."""
    fresh, old = (np.float32(0.5) * (a + b) for a, b in (now, before))
    picture = fresh.reshape(*shape, 3)
    mean = _blurred(picture)
    deviation = np.sqrt(np.maximum(_blurred(picture**2) - mean**2, 0.0))
    reach = np.float32(_CLAMP_DEVIATIONS) * deviation
    low, high = ((mean + side * reach).reshape(-1, 3) for side in (-1, 1))
    shift = np.clip(old, low, high) - old
    return [half + shift for half in before]


def _blurred(picture: Pixels) -> Pixels:
    """(H, W, 3) means over the pixels around each; fewer at the edges."""
    for axis in (0, 1):
        size, reach = picture.shape[axis], _NEIGHBOURS_PIXELS
        sums = np.cumsum(picture, axis=axis, dtype=np.float64)
        sums = np.concatenate([np.zeros_like(sums.take([0], axis)), sums], axis=axis)
        last = np.minimum(np.arange(size) + reach + 1, size)
        first = np.maximum(np.arange(size) - reach, 0)
        counts = (last - first).reshape([-1 if a == axis else 1 for a in range(3)])
        picture = ((sums.take(last, axis) - sums.take(first, axis)) / counts).astype(np.float32)
    return picture
