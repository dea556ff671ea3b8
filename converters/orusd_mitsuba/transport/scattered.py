"""What surfaces that a path has come to scatter back along it: the rest of the path, in one place.

An integrator that finds the direct light of a ray itself, with emission and sky weighted against
its own light samples, needs only the scattered light of the surface that the ray meets. Here are
the contract for that and its reference, which goes on tracing paths.
"""

from typing import Any, Protocol

from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import Accumulator, Prefix, trace


class ScatteredLight(Protocol):
    """Finds what surfaces scatter back along the rays that meet them."""

    is_cheap: bool
    """Whether it takes no more time than few rays, so that a path may be split before it."""

    def add(
        self,
        sampler: Any,
        ray: Any,
        si: Any,
        throughput: Any,
        scatterings: Any,
        crossed: Any,
        accumulator: Accumulator,
        active: Any,
    ) -> None:
        """Add throughput x the radiance that surfaces scatter back, by light.

        What a surface emits is not included, nor what comes straight on through one that is clear:
        the caller lets a part of the paths pass there. Where it has stopped a path by chance, the
        throughput is divided by that chance. Runs inside and outside loops of Dr.Jit.

        Args:
            sampler: Random numbers, one stream for each path.
            ray: Arrives at the surfaces.
            si: The surfaces that it meets.
            throughput: What a path carries there, a colour.
            scatterings: How often it was scattered before.
            crossed: The opening that it has crossed last, with ``ray``.
            accumulator: Receives the contributions.
            active: Which paths there are.
        """
        ...


class TracedLight:
    """The reference: goes on tracing the paths, as `trace` does.

    Args:
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        depth: At most this many segments of a whole path.
    """

    is_cheap = False

    def __init__(self, built: Any, index: LightIndex, depth: int) -> None:
        self._built, self._index, self._depth = built, index, depth

    def add(
        self,
        sampler: Any,
        ray: Any,
        si: Any,
        throughput: Any,
        scatterings: Any,
        crossed: Any,
        accumulator: Accumulator,
        active: Any,
    ) -> None:
        """See `ScatteredLight`: the ray is cast again, which costs less than to carry ``si``."""
        trace(
            self._built,
            self._index,
            sampler,
            ray,
            accumulator,
            self._depth,
            active=active & si.is_valid(),
            prefix=Prefix(throughput, scatterings, crossed),
        )
