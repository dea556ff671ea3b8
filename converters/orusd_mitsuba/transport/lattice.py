"""Random numbers of a pixel's samples that are spread evenly over the first dimensions.

The samples of a pixel are a lattice in each pair of dimensions, one of them cut into as many steps
as there are samples, the other stepping by the golden ratio. No two pairs use it in the same order.
Each pixel shifts it at random in every dimension (Cranley and Patterson 1976): so each sample by
itself is uniform in all dimensions together, and means are unbiased. Permuting samplers such as
Mitsuba's ``multijitter`` save a little more, but with few samples their dimensions are correlated;
with one, a white room of fifty bounces came out two per cent too dark.
"""

from math import gcd
from typing import Any, Final

import drjit as dr
import mitsuba as mi

# 2^32 over the golden ratio, and times the square root of two less one.
_GOLDEN_STEP: Final = 2654435769
_SILVER_STEP: Final = 1779033704
# About how far the orders of the pairs step, in parts of the samples.
_STRIDES_OF_PAIRS: Final = (0.0, 0.38, 0.28)
_DIMENSIONS: Final = 7
TEA_ROUNDS: Final = 8
"""After four, Mitsuba's default, the first of both numbers is not yet even."""

_BELOW_ONE: Final = 1.0 - 2.0**-24


class FirstDimensions:
    """What paths begin with; those of a pixel are side by side.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        samples: Paths of a pixel.
        paths: All of them.
        sampler: Seeded for as many threads as there are pixels.

    Attributes:
        light: Two numbers that the first surface looks for light by.
        direction: Two that it chooses a direction by.
        pixel: Two for the place in the pixel.
        lobe: The one that the first surface chooses its lobe by.
    """

    def __init__(self, samples: int, paths: int, sampler: Any) -> None:
        path, count = dr.arange(mi.UInt32, paths), dr.opaque(mi.UInt32, samples)
        step = dr.opaque(mi.Float, 1.0 / samples)
        pixel, number = path // count, path % count
        shifts = [dr.gather(mi.Float, sampler.next_1d(), pixel) for _ in range(_DIMENSIONS)]
        pairs = []
        for pair, part in enumerate(_STRIDES_OF_PAIRS):
            turned = number * dr.opaque(mi.UInt32, coprime(samples, part)) % count
            across = (mi.Float(turned) * step + shifts[2 * pair], shifts[2 * pair + 1])
            along = mi.Float(turned * mi.UInt32(_GOLDEN_STEP)) * 2.0**-32
            pairs.append(mi.Point2f(_wrapped(across[0]), _wrapped(across[1] + along)))
        self.light, self.direction, self.pixel = pairs
        self.lobe = _wrapped(mi.Float(number * mi.UInt32(_SILVER_STEP)) * 2.0**-32 + shifts[6])


class PixelLattice:
    """The same for threads that take the samples of a pixel in turn, with pairs without end.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        samples: Of each pixel.
        pixel: The number of each thread's pixel.
        sample: The number of the sample that it takes now.
        seed: Of the shifts.
    """

    def __init__(self, samples: int, pixel: Any, sample: Any, seed: int) -> None:
        # As variables, not as parts of the compiled code.
        self._count, self._seed = dr.opaque(mi.UInt32, samples), dr.opaque(mi.UInt32, seed)
        self._step = dr.opaque(mi.Float, 1.0 / samples)
        self._strides = [dr.opaque(mi.UInt32, coprime(samples, part)) for part in _STRIDES_OF_PAIRS]
        self._pixel, self._sample = pixel, sample

    def pair(self, salt: Any, order: int = 0) -> Any:
        """Two numbers for each thread.

        Args:
            salt: Tells pairs apart, a number below 2^31.
            order: Pairs of different orders take the lattice in different ways, of three.
        """
        turned = self._sample * self._strides[order] % self._count
        first, second = self._shifts(2 * mi.UInt32(salt))
        across = mi.Float(turned) * self._step + first
        along = mi.Float(turned * mi.UInt32(_GOLDEN_STEP)) * 2.0**-32 + second
        return mi.Point2f(_wrapped(across), _wrapped(along))

    def single(self, salt: Any) -> Any:
        """One number for each thread; see `pair`."""
        shift, _ = self._shifts(2 * mi.UInt32(salt) + 1)
        return _wrapped(mi.Float(self._sample * mi.UInt32(_SILVER_STEP)) * 2.0**-32 + shift)

    def _shifts(self, salt: Any) -> tuple[Any, Any]:
        drawn: Any = mi.sample_tea_32
        first, second = drawn(self._pixel, salt ^ self._seed, TEA_ROUNDS)
        return mi.Float(first) * 2.0**-32, mi.Float(second) * 2.0**-32


def coprime(count: int, part: float) -> int:
    """The least number from a part of ``count`` on that has no factor in common with it."""
    step = max(1, round(part * count))
    while gcd(step, count) != 1:
        step += 1
    return step


def _wrapped(value: Any) -> Any:
    return dr.minimum(value - dr.floor(value), _BELOW_ONE)
