"""Direct light of the surroundings, by the opening that it comes through."""

from typing import Any

import drjit as dr
import mitsuba as mi

from orusd_mitsuba.direct.accumulator import DirectAccumulator
from orusd_mitsuba.direct.receiver import Between, Receiver
from orusd_mitsuba.direct.rectangles import Rectangles
from orusd_mitsuba.transport.light_index import LightIndex


class Sky:
    """The surroundings, sampled by their own importance, by openings and by the hemisphere.

    Args:
        built: The Mitsuba scene, which has an environment.
        index: Its lights.
        between: What stands before them.
        openings: Where the surroundings come in.
    """

    def __init__(
        self, built: Any, index: LightIndex, between: Between, openings: Rectangles
    ) -> None:
        self._index, self._between = index, between
        self._emitter, self._openings = built.environment(), openings

    def gather(self, at: Receiver, sampler: Any, sums: DirectAccumulator) -> None:
        """Sample a direction by the surroundings' own importance, and one through each opening."""
        ds, _ = self._emitter.sample_direction(at.si, sampler.next_2d(), at.active)
        self.add(at, ds.d, ds.pdf, at.active & (ds.pdf > 0.0), sums)
        if len(self._openings):
            self._through_openings(at, sampler, sums)

    @dr.syntax
    def _through_openings(self, at: Receiver, sampler: Any, sums: DirectAccumulator) -> None:
        row = mi.UInt32(0)
        while row < len(self._openings):
            direction, density = self._openings.sample(row, at.si.p, sampler.next_2d())
            light = self._index.crossed(at.si.p, direction, mi.Float(dr.inf), at.crossed)
            # Behind one opening there may be another, whose own samples find it.
            active = at.active & (density > 0.0) & (light == self._openings.light(row))
            self.add(at, direction, density, active, sums)
            row += 1

    def add(
        self, at: Receiver, direction: Any, density: Any, active: Any, sums: DirectAccumulator
    ) -> None:
        """Add what comes along a direction that one technique has drawn with a density."""
        active = active & (at.cosine(direction) > 0.0)
        light = self._index.crossed(at.si.p, direction, mi.Float(dr.inf), at.crossed)
        ds = dr.zeros(mi.DirectionSample3f, sums.paths)
        ds.d = direction
        techniques = (
            self._emitter.pdf_direction(at.si, ds, active),
            self._openings.density(light, at.si.p, direction),
            at.density(direction),
        )
        others = sum(dr.square(other / density) for other in techniques)
        towards = dr.zeros(mi.SurfaceInteraction3f, sums.paths)
        towards.wi = -direction
        # The power heuristic: the square of the technique's own density over all of them.
        value = self._emitter.eval(towards, active) * (at.cosine(direction) / (density * others))
        seen = self._between.unblocked(at.si.spawn_ray(direction), active)
        sums.add(light, value, seen, active)
