"""How light that arrives along many rays is found: by paths, or as another method does it."""

from collections.abc import Callable
from typing import Any, Final, Protocol

import drjit as dr
import mitsuba as mi

from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import PathAccumulator, random_numbers, trace

# For each direction: they cost a tenth of the paths.
_LIGHT_SAMPLES_PER_PATH: Final = 2


class Start:
    """Where rays begin.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        at: The interactions there, from which lights are sampled too.
        ray: The rays.
        density: Of their directions, relative to that of the light samples.
        active: Which there are.
    """

    def __init__(self, at: Any, ray: Any, density: Any, active: Any) -> None:
        self.at, self.ray, self.density, self.active = at, ray, density, active


Begin = Callable[[Any], Start]
"""Gives where rays begin by their numbers."""


class Arrival(Protocol):
    """Finds what arrives along many rays."""

    def light_samples(self, cells: int) -> int:
        """Light samples that a point shall have for each direction of its so many cells."""
        ...

    def arriving(self, begin: Begin, rays: int, seed: int) -> tuple[Any, Any]:
        """The radiance that arrives along rays.

        Args:
            begin: Gives them by number.
            rays: How many.
            seed: Of random numbers.

        Returns:
            What comes straight from lights, weighted against light samples by the power heuristic,
            and what comes by way of surfaces: a colour for each ray.
        """
        ...


class TracedArrival:
    """The reference: a path along each ray is followed to its end.

    Args:
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        depth: At most this many segments.
    """

    def __init__(self, built: Any, index: LightIndex, depth: int) -> None:
        self._built, self._index, self._depth = built, index, depth

    def light_samples(self, cells: int) -> int:
        """See `Arrival`."""
        return reference_light_samples(cells)

    def arriving(self, begin: Begin, rays: int, seed: int) -> tuple[Any, Any]:
        """See `Arrival`."""
        start = begin(dr.arange(mi.UInt32, rays))
        sampler, sums = random_numbers(seed, rays), PathAccumulator(rays, None)
        trace(
            self._built,
            self._index,
            sampler,
            start.ray,
            sums,
            self._depth,
            active=start.active,
            begun=(start.at, start.density),
        )
        never, once, more = (
            mi.Color3f(*(_part(sums.kinds, 3 * kind + channel, rays) for channel in range(3)))
            for kind in range(3)
        )
        return never, once + more


def reference_light_samples(cells: int) -> int:
    """Of the reference, for each direction of a point's cells."""
    return _LIGHT_SAMPLES_PER_PATH * cells


def _part(entries: Any, row: int, length: int) -> Any:
    """A row of a plane of numbers."""
    start = dr.opaque(mi.UInt32, row * length)
    return dr.gather(mi.Float, entries, start + dr.arange(mi.UInt32, length))
