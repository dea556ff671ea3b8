"""Path tracing that sums every contribution by its light, and by how often it was scattered.

The estimator is that of Mitsuba's ``path``: light sampling and BSDF sampling, combined by the power
heuristic (Veach 1997), and Russian roulette after the fifth vertex. At that more paths survive, by
the square root of what they carry: behind a curtain a path that carries little still meets most of
the light. The sums add up to what ``path`` would return. No backend adds in another order from run
to run, because every path has sums of its own.
"""

from copy import copy
from typing import Any, Final, Protocol

import drjit as dr
import mitsuba as mi

from orusd_mitsuba.transport.light_index import LightIndex

# What the radiance of a path is made of, by the number of scatterings between light and camera.
KINDS: Final = ("emission", "direct", "indirect")
# As in Mitsuba's path integrator.
_ROULETTE_FROM_SEGMENT: Final = 5
_MOST_SURVIVAL: Final = 0.95


class Accumulator(Protocol):
    """Receives what paths bring."""

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """Add a contribution of the path in whose thread this runs.

        Args:
            value: Radiance times throughput, a colour.
            light: Where it comes from, by number.
            scatterings: How often it was scattered on its way.
            active: Where there is one.
        """
        ...


class PathAccumulator:
    """Sums of the contributions of light paths, one for each path: zero at first.

    Red, green and blue of a row lie side by side.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Attributes:
        paths: How many paths there are.
        kinds: (3 * 3 * paths) what was scattered never, once and more often.
        lights: (lights * 3 * paths) what comes from each light; None where it is not wanted.
    """

    def __init__(self, paths: int, lights: int | None) -> None:
        self.paths = paths
        self._stride = dr.opaque(mi.UInt32, paths)
        self._slots: Any = None
        self.kinds = dr.zeros(mi.Float, len(KINDS) * 3 * paths)
        self.lights = None if lights is None else dr.zeros(mi.Float, lights * 3 * paths)

    def part(self, paths: Any) -> "PathAccumulator":
        """The same sums for threads that are some of the paths, by their numbers."""
        found = copy(self)
        found._slots = paths
        return found

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """Add a contribution of the path in whose thread this runs."""
        slot = dr.arange(mi.UInt32, self.paths) if self._slots is None else self._slots
        kind = dr.minimum(scatterings, len(KINDS) - 1)
        for entries, row in ((self.lights, light), (self.kinds, kind)):
            if entries is None:
                continue
            for channel in range(3):
                place = (row * 3 + channel) * self._stride + slot
                dr.scatter_reduce(
                    dr.ReduceOp.Add,
                    entries,
                    value[channel],
                    place,
                    active,
                    mode=dr.ReduceMode.NoConflicts,
                )


class Prefix:
    """What paths went through before the rays that `trace` is given.

    The caller has counted what these rays meet straight, emission and sky, what goes straight on
    through the surfaces that they meet, and the panes on their way; or nothing of that.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        throughput: What the paths carry, a colour.
        scatterings: How often they were scattered.
        crossed: The openings that they have crossed.
        counted: Whether the caller has counted all that.
    """

    def __init__(
        self, throughput: Any, scatterings: Any, crossed: Any, *, counted: bool = True
    ) -> None:
        self.throughput = throughput
        self.scatterings, self.crossed = scatterings, crossed
        self.counted = counted


@dr.syntax
def trace(
    built: Any,
    index: LightIndex,
    sampler: Any,
    ray: Any,
    accumulator: Accumulator,
    depth: int,
    first: Any = None,
    active: Any = True,
    begun: Any = None,
    numbers: Any = None,
    prefix: Any = None,
    looks_through: bool = False,
) -> None:
    """Follow one path along each ray and add up what it brings.

    Args:
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        sampler: Seeded for as many paths as there are rays.
        ray: Where the paths begin.
        accumulator: Receives the contributions.
        depth: At most this many segments; with at most 7 scatterings 8.
        first: Gives the BSDF of the first surface, such as a white one for irradiance; None: its
            own.
        active: Which rays to follow.
        begun: Where the caller samples lights from the rays' origins too: the interactions there,
            and the density of the rays' directions relative to that of the light samples. What
            the first segment meets is then weighted against these. None: it counts in full.
        numbers: `FirstDimensions` that the first surface draws by; None: the sampler's.
        prefix: `Prefix`, what the paths went through before; None: they begin with the rays.
        looks_through: Whether the rays go straight through panes: the caller finds what these
            mirror. Else chance decides.
    """
    after = prefix is not None and prefix.counted
    context = mi.BSDFContext()
    ray = mi.Ray3f(ray)
    throughput = mi.Color3f(1.0)
    segments, scatterings = mi.UInt32(0), mi.UInt32(0)
    before = dr.zeros(mi.SurfaceInteraction3f)
    density, certain = mi.Float(1.0), mi.Bool(True)
    if dr.hint(begun is not None, mode="scalar"):
        before, density, certain = begun[0], mi.Float(begun[1]), mi.Bool(False)
    crossed = dr.opaque(mi.UInt32, index.elsewhere)
    start = mi.UInt32(0)
    if dr.hint(prefix is not None, mode="scalar"):
        throughput, crossed = mi.Color3f(prefix.throughput), mi.UInt32(prefix.crossed)
        scatterings, segments = mi.UInt32(prefix.scatterings), mi.UInt32(prefix.scatterings)
        start = mi.UInt32(prefix.scatterings)
    active = mi.Bool(active)
    while active:
        si = built.ray_intersect(ray, mi.RayFlags.All, segments == 0, active)
        hit = si.is_valid()
        end = dr.select(hit, si.t, dr.inf)
        later = segments > start
        passed, turned, onto, end = index.meet_panes(
            ray, end, sampler, active & (later | (not after)), later | (not looks_through)
        )
        throughput *= passed
        crossed = index.crossed(ray.o, ray.d, end, crossed)
        # 1. Light that the ray has met (BSDF sampling).
        emitter = si.emitter(built)
        emits = active & ~turned & (emitter != None)  # noqa: E711
        if dr.hint(first is not None, mode="scalar"):
            # What is received is wanted, not what the surface itself sends out.
            emits &= scatterings > 0
        if dr.hint(after, mode="scalar"):
            emits &= segments > start
        ds = mi.DirectionSample3f(built, si, before)
        other = dr.select(certain, 0.0, built.pdf_emitter_direction(before, ds, emits & ~certain))
        met = throughput * emitter.eval(si, emits) * power_heuristic(density, other)
        light = dr.select(hit, index.of_shape(si.shape, emits & hit), crossed)
        # What is seen straight is seen whatever it lights.
        met *= dr.select(scatterings > 0, index.lit(light, before.shape, emits), 1.0)
        accumulator.add(met, light, scatterings, emits)
        # 2. Light that is looked for (next event estimation).
        further = active & (segments + 1 < depth)
        onwards = further & hit & ~turned
        bsdf = si.bsdf()
        if dr.hint(first is not None, mode="scalar"):
            bsdf = dr.select(scatterings == 0, first(si), bsdf)
        rough = onwards & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
        looking, lobe, turning = sampler.next_2d(), sampler.next_1d(), sampler.next_2d()
        if dr.hint(numbers is not None, mode="scalar"):
            looking = dr.select(segments == 0, numbers.light, looking)
            lobe = dr.select(segments == 0, numbers.lobe, lobe)
            turning = dr.select(segments == 0, numbers.direction, turning)
        to, incident = built.sample_emitter_direction(si, looking, False, rough)
        value, pdf, sample, weight = bsdf.eval_pdf_sample(
            context, si, si.to_local(to.d), lobe, turning, onwards
        )
        # A shadow ray is cast only where it decides on something.
        smooth = rough & (to.pdf != 0.0) & dr.any(value * incident != 0.0)
        incident *= index.unblocked(si, to, smooth)
        null = mi.has_flag(sample.sampled_type, mi.BSDFFlags.Null)
        null &= ~turned
        certain = mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta) | null | turned
        density = dr.select(turned, 1.0, sample.pdf)
        infinite = mi.has_flag(to.emitter.flags(), mi.EmitterFlags.Infinite)
        shape = to.emitter.get_shape()
        share = dr.select(to.delta, 1.0, power_heuristic(to.pdf, pdf))
        lamp = index.of_shape(shape, smooth & ~infinite)
        sky = index.crossed(si.p, to.d, mi.Float(dr.inf), crossed)
        source = dr.select(infinite, sky, lamp)
        found = throughput * value * incident * share * index.lit(source, si.shape, smooth)
        accumulator.add(found, source, scatterings + 1, smooth)
        # 3. Onwards.
        ray = dr.select(turned, onto, si.spawn_ray(si.to_world(sample.wo)))
        throughput *= dr.select(turned, 1.0, weight)
        before = si
        scatterings = dr.select(null, scatterings, scatterings + 1)
        segments += 1
        strongest = dr.max(throughput)
        survival = dr.minimum(dr.sqrt(strongest), _MOST_SURVIVAL)
        roulette = segments >= _ROULETTE_FROM_SEGMENT
        kept = ~roulette | (sampler.next_1d() < survival)
        throughput[roulette] /= survival
        active = (onwards | (further & turned)) & kept & (strongest > 0.0)
        if dr.hint(after, mode="scalar"):
            active &= ~null | (segments > start + 1)


def random_numbers(seed: int, count: int) -> Any:
    """Independent ones, for so many paths."""
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed & 0xFFFFFFFF, count)
    return sampler


def power_heuristic(used: Any, other: Any) -> Any:
    """The power heuristic for two techniques."""
    squared = dr.square(used)
    share = squared / (squared + dr.square(other))
    return dr.select(dr.isfinite(share), share, 0.0)
