"""What surfaces that a path has come to scatter back along it: the rest of the path, in one place.

An integrator that finds the direct light of a ray itself, with emission and sky weighted against
its own light samples, needs only the scattered light of the surface that the ray meets.
"""

from typing import Any

from orusd_mitsuba.transport.path_tracing import Accumulator, Prefix
from orusd_mitsuba.transport.paths import Paths


class ScatteredLight:
    """Finds what surfaces scatter back along the rays that meet them.

    Args:
        paths: Follows what is left of a whole path.
        is_cheap: Whether that takes no more time than few rays, so that a path may be split before
            it.
    """

    def __init__(self, paths: Paths, *, is_cheap: bool) -> None:
        self._paths, self.is_cheap = paths, is_cheap

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
        # The ray is cast again, which costs less than to carry ``si``.
        prefix = Prefix(throughput, scatterings, crossed)
        self._paths.follow(sampler, ray, accumulator, active=active & si.is_valid(), prefix=prefix)
