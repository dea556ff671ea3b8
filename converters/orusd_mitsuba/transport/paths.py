"""How paths are followed: to their end, which is the reference, or as another method does it."""

from typing import Any, Protocol

from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import Accumulator, trace


class Paths(Protocol):
    """Follows one path along each of many rays."""

    def follow(
        self,
        sampler: Any,
        ray: Any,
        accumulator: Accumulator,
        *,
        first: Any = None,
        active: Any = True,
        begun: Any = None,
        numbers: Any = None,
        prefix: Any = None,
        looks_through: bool = False,
    ) -> None:
        """Follow one path along each ray and add up what it brings.

        Args:
            sampler: Seeded for as many paths as there are rays.
            ray: Where the paths begin.
            accumulator: Receives the contributions.
            first: As of `orusd_mitsuba.transport.path_tracing.trace`, like all that follows.
            active: Which rays to follow.
            begun: Where the caller samples lights from the rays' origins too.
            numbers: What the first surface draws by.
            prefix: What the paths went through before.
            looks_through: Whether the rays go straight through panes.
        """
        ...


class TracedPaths:
    """The reference: every path is followed to its end.

    Args:
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        depth: At most this many segments.
    """

    def __init__(self, built: Any, index: LightIndex, depth: int) -> None:
        self._built, self._index, self._depth = built, index, depth

    def follow(self, sampler: Any, ray: Any, accumulator: Accumulator, **how: Any) -> None:
        """See `Paths`."""
        trace(self._built, self._index, sampler, ray, accumulator, self._depth, **how)
