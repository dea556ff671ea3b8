"""What surfaces scatter back along rays, by the light cache."""

from typing import Any

from orusd_mitsuba.transport.path_tracing import Accumulator, Prefix
from orusd_mitsuba.transport.paths import Paths


class CachedLight:
    """See `orusd_mitsuba.transport.scattered.ScatteredLight`.

    Args:
        paths: Paths from a camera that end in the cache.
    """

    is_cheap = True

    def __init__(self, paths: Paths) -> None:
        self._paths = paths

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
        prefix = Prefix(throughput, scatterings, crossed)
        self._paths.follow(sampler, ray, accumulator, active=active & si.is_valid(), prefix=prefix)
