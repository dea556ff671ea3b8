"""Paths that end in the light cache: one or two segments instead of eight.

At a surface that the cache knows, what is scattered diffusely is the surface's own albedo times the
cached irradiance, by light; only the lobe is followed on, with a chance in proportion to what it
reflects. Where the cache is not to be trusted, the path goes on as in
`orusd_mitsuba.transport.path_tracing`. That holds at the first surface, where a ray is short
against a surfel (corners, gaps, contacts) and where no surfel was filled. It holds at surfaces that
are not in the table of materials, too (clear ones, foreign models).
"""

from typing import Any, Final, Protocol

import drjit as dr
import mitsuba as mi
import numpy as np

from orusd_mitsuba.plugins import microfacet
from orusd_mitsuba.plugins.material_table import MaterialTable
from orusd_mitsuba.plugins.openrooms_bsdf import Reflection
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import power_heuristic

# A lobe is followed on with this chance for all that it reflects of even light, and at least with
# the second one where it reflects anything.
CHANCE_PER_ALBEDO: Final = 2.0
LEAST_CHANCE: Final = 0.1
LEAST_LOBE_ALBEDO: Final = 1e-4
_ROULETTE_FROM_SEGMENT: Final = 5
_MOST_SURVIVAL: Final = 0.95


class CacheLookup(Protocol):
    """What is known of surfaces."""

    passing: bool
    """Whether any surface passes light on diffusely."""

    def find(self, si: Any, towards: Any, active: Any, *, through: bool = False) -> tuple[Any, Any]:
        """The surfel on the side that ``towards`` points to, and whether it is filled.

        Args:
            si: Interactions on surfaces.
            towards: To the side that is meant.
            active: Where it is wanted.
            through: Whether it shall be the one for what arrives at the other side.
        """
        ...

    def trusted(self, distance: Any, scatterings: Any) -> Any:
        """Whether surfels are small beside a ray of that length, after so many scatterings."""
        ...

    def add(
        self,
        surfel: Any,
        weight: Any,
        scatterings: Any,
        crossed: Any,
        sums: Any,
        active: Any,
        through: bool,
    ) -> None:
        """Add a weight times the irradiance of a surfel, by light.

        Args:
            surfel: Its number.
            weight: Colour.
            scatterings: Between the surfel and where the path began, itself included.
            crossed: The opening that the path has crossed last: light that has come in through
                none before belongs to it.
            sums: What receives it.
            active: Where.
            through: Whether it is the surfel for what arrives at the other side.
        """
        ...


class TracingScene:
    """What paths are followed in.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        materials: The table that surfaces are rows of.
        rows: By registered shape, whether it is one: uint32, 0 or 1.
        known: The cache.
        depth: At most this many segments of a path.
    """

    def __init__(
        self,
        built: Any,
        index: LightIndex,
        materials: MaterialTable,
        rows: Any,
        known: CacheLookup,
        depth: int,
    ) -> None:
        self.built, self.index, self.materials = built, index, materials
        self.known, self.depth = known, depth
        self._rows = rows
        self.mixed = not bool(np.asarray(rows.numpy()).all())

    def knowing(self, known: CacheLookup) -> "TracingScene":
        """The same with another cache."""
        return TracingScene(self.built, self.index, self.materials, self._rows, known, self.depth)

    def tabulated(self, shape: Any, active: Any) -> Any:
        """Whether shapes have a row in the table of materials."""
        if not self.mixed:
            return mi.Bool(active)
        number: Any = dr.reinterpret_array(mi.UInt32, shape)
        return active & (dr.gather(mi.UInt32, self._rows, number, active) == 1)


@dr.syntax
def follow(
    around: TracingScene,
    sampler: Any,
    ray: Any,
    sums: Any,
    first: Any = None,
    active: Any = True,
    begun: Any = None,
    numbers: Any = None,
    prefix: Any = None,
    counted: Any = None,
    looks_through: bool = False,
) -> None:
    """Follow one path along each ray into the cache and add up what it brings.

    Args:
        around: The scene and what is known of it.
        sampler: Seeded for as many paths as there are rays.
        ray: Where the paths begin.
        sums: Receives the contributions, by ``add`` of a `PathAccumulator`.
        first: Gives the BSDF of the first surface, such as a white one; None: its own.
        active: Which rays to follow.
        begun: As of `orusd_mitsuba.transport.path_tracing.trace`. The cache then counts from the
            first surface that is met, else from the second one.
        numbers: `FirstDimensions` that the first surface draws by; None: the sampler's.
        prefix: As of ``trace``; the cache then counts from the first surface that is met, if the
            caller has counted what is met straight.
        counted: Where what is known of the first surface has been added, and what paths carry that
            go on by its lobe: a mask, and a number. None: nowhere.
        looks_through: As of ``trace``.
    """
    after = prefix is not None and prefix.counted
    built, index, known = around.built, around.index, around.known
    context = mi.BSDFContext()
    ray = mi.Ray3f(ray)
    throughput = mi.Color3f(1.0)
    segments, scatterings = mi.UInt32(0), mi.UInt32(0)
    before = dr.zeros(mi.SurfaceInteraction3f)
    density, certain = mi.Float(1.0), mi.Bool(True)
    since = 1
    if dr.hint(begun is not None, mode="scalar"):
        before, density, certain = begun[0], mi.Float(begun[1]), mi.Bool(False)
        since = 0
    crossed = dr.opaque(mi.UInt32, index.elsewhere)
    start = mi.UInt32(0)
    if dr.hint(prefix is not None, mode="scalar"):
        throughput, crossed = mi.Color3f(prefix.throughput), mi.UInt32(prefix.crossed)
        scatterings, segments = mi.UInt32(prefix.scatterings), mi.UInt32(prefix.scatterings)
        start = mi.UInt32(prefix.scatterings)
        # What is seen in a pane is looked at as closely as what is seen straight.
        since = 1 if prefix.counted else 2
    done, carried = mi.Bool(False), mi.Float(1.0)
    if dr.hint(counted is not None, mode="scalar"):
        done, carried = mi.Bool(counted[0]), mi.Float(counted[1])
        throughput *= mi.Color3f(carried)
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
        # 1. Light that the ray has met.
        emitter = si.emitter(built)
        emits = active & ~turned & (emitter != None)  # noqa: E711
        if dr.hint(first is not None, mode="scalar"):
            emits &= scatterings > 0
        if dr.hint(after, mode="scalar"):
            emits &= segments > start
        ds = mi.DirectionSample3f(built, si, before)
        other = dr.select(certain, 0.0, built.pdf_emitter_direction(before, ds, emits & ~certain))
        met = throughput * emitter.eval(si, emits) * power_heuristic(density, other)
        light = dr.select(hit, index.of_shape(si.shape, emits & hit), crossed)
        sums.add(met, light, scatterings, emits)
        # 2. What is known of the surface.
        further = active & (segments + 1 < around.depth)
        onwards = further & hit & ~turned
        tabulated = around.tabulated(si.shape, onwards)
        matter = around.materials(si, tabulated)
        ends = tabulated & (scatterings >= since) & known.trusted(si.t, scatterings + 1)
        surfel, found = known.find(si, -ray.d, ends)
        ends &= found
        if dr.hint(known.passing, mode="scalar"):
            passes = ends & (matter.transmission > 0.0)
            behind, filled = known.find(si, -ray.d, passes, through=True)
            passes &= filled
            ends &= passes | (matter.transmission <= 0.0)
            share = matter.diffuse * (matter.transmission * dr.inv_pi)
            passes &= ~done
            brought = throughput * share
            known.add(behind, brought, scatterings + 1, crossed, sums, passes, True)
        brought = throughput * matter.diffuse * dr.inv_pi
        known.add(surfel, brought, scatterings + 1, crossed, sums, ends & ~done, False)
        # 3. Of what the cache knows only the lobe goes on.
        full: Any = dr.select(ends, mi.Float(0.0), mi.Float(1.0))
        reflection = Reflection.of(matter, si, 1.0, full, full)
        albedo = microfacet.lobe_albedo(reflection.view.wi.z, matter.roughness, matter.specular)
        lobe = matter.gloss * mi.luminance(albedo)
        chance = dr.clip(CHANCE_PER_ALBEDO * lobe, LEAST_CHANCE, 1.0)
        chance = dr.select(ends, dr.select(lobe > LEAST_LOBE_ALBEDO, chance, 0.0), 1.0)
        chance = dr.select(done, 1.0, chance)
        done = mi.Bool(False)
        onwards &= sampler.next_1d() < chance
        throughput /= dr.select(onwards, chance, 1.0)
        # 4. Light that is looked for.
        looking, choice, turning = sampler.next_2d(), sampler.next_1d(), sampler.next_2d()
        if dr.hint(numbers is not None, mode="scalar"):
            looking = dr.select(segments == 0, numbers.light, looking)
            choice = dr.select(segments == 0, numbers.lobe, choice)
            turning = dr.select(segments == 0, numbers.direction, turning)
        to, incident = built.sample_emitter_direction(si, looking, False, onwards)
        local = si.to_local(to.d)
        wo, _ = reflection.direction(choice, turning)
        way = reflection.view.frame.to_world(wo)
        value, pdf = reflection.value(reflection.view.frame.to_local(local), local)
        scattered, drawn = reflection.value(wo, way)
        weight = dr.select(drawn > 0.0, scattered / dr.select(drawn > 0.0, drawn, 1.0), 0.0)
        null, sharp = mi.Bool(False), mi.Bool(False)
        if dr.hint(around.mixed or first is not None, mode="scalar"):
            bsdf, foreign = si.bsdf(), onwards & ~tabulated
            if dr.hint(first is not None, mode="scalar"):
                white = onwards & (scatterings == 0)
                bsdf = dr.select(white, first(si), bsdf)
                foreign |= white
            v, p, sample, w = bsdf.eval_pdf_sample(context, si, local, choice, turning, foreign)
            value, pdf = dr.select(foreign, v, value), dr.select(foreign, p, pdf)
            way = dr.select(foreign, sample.wo, way)
            weight, drawn = dr.select(foreign, w, weight), dr.select(foreign, sample.pdf, drawn)
            null = foreign & mi.has_flag(sample.sampled_type, mi.BSDFFlags.Null)
            sharp = foreign & (null | mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta))
        lit = onwards & (to.pdf != 0.0) & dr.any(value * incident != 0.0)
        incident *= index.unblocked(si, to, lit)
        infinite = mi.has_flag(to.emitter.flags(), mi.EmitterFlags.Infinite)
        share = dr.select(to.delta, 1.0, power_heuristic(to.pdf, pdf))
        lamp = index.of_shape(to.emitter.get_shape(), lit & ~infinite)
        sky = index.crossed(si.p, to.d, mi.Float(dr.inf), crossed)
        brought = throughput * value * incident * share
        sums.add(brought, dr.select(infinite, sky, lamp), scatterings + 1, lit)
        # 5. Onwards.
        ray = dr.select(turned, onto, si.spawn_ray(si.to_world(way)))
        throughput *= dr.select(turned, 1.0, weight)
        before, density, certain = si, dr.select(turned, 1.0, drawn), sharp | turned
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
