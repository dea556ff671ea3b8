"""Light that arrives at points by very many rays, as of environment maps, looked up at most.

Of most rays nothing is asked but which surfel they meet and what that sends on. What is left (lamps
and sky, short rays, strong lobes, surfaces that are not known) is a small part. It is gathered and
followed apart, so that no ray waits for its neighbours' longer ways: to the first surface, with a
sample of the lights and one direction from there, whose end is looked up in its turn. Rays that
meet a clear pane are followed as any path is; of panes on the way from a first surface no mirror
images are looked for.
"""

from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Floats
from openrooms_usd.rendering.scene.arrays import Scene
from orusd_mitsuba.cache.filling import CacheData
from orusd_mitsuba.cache.surfels import SurfelIndex
from orusd_mitsuba.cache.tracing import CHANCE_PER_ALBEDO, TracingScene, follow
from orusd_mitsuba.plugins.memory import aligned
from orusd_mitsuba.plugins.openrooms_bsdf import Reflection
from orusd_mitsuba.transport.arrival import Begin, Start
from orusd_mitsuba.transport.lattice import TEA_ROUNDS
from orusd_mitsuba.transport.path_tracing import Prefix, power_heuristic, random_numbers

# Set in the piece of a triangle that emits, and of one whose surface is not known.
_EMITS: Final = 1 << 31
_FOREIGN: Final = 1 << 30
# Light samples of a point for each direction of its cells: lamps fall into few of them, and what is
# broad is found by the directions.
_LIGHT_SAMPLES: Final = 64
# Rays shorter than this many edges of a surfel do not look it up: the first one, and the next.
_NEAREST_PER_SIZE: Final = 0.75
_NEAREST_SECOND_PER_SIZE: Final = 0.25
# What lobes that reflect less than this of even light send is taken as even.
_LEAST_LOBE_ALBEDO: Final = 0.1
# Set random numbers apart.
_CHANCE_SALT: Final = 0x6C6F6265
_ONCE_SALT: Final = 0x6F6E6365
_ONWARDS_SALT: Final = 0x6F6E7761
_GLAZED_SALT: Final = 0x676C617A


class LookedUpArrival:
    """See `orusd_mitsuba.transport.arrival.Arrival`.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        scene: The arrays.
        around: The scene as paths are followed in it, and its cache.
        data: What `filling.fill` made.
        tabulated: (patches,) whether each has a row in the table of materials.
    """

    def __init__(self, scene: Scene, around: TracingScene, data: CacheData, tabulated: Any) -> None:
        self._around, self._built = around, around.built
        self._light = SurfelLight(scene, around.built, data, tabulated)
        strong = data.lobe >= _LEAST_LOBE_ALBEDO
        chance = np.where(strong, np.minimum(CHANCE_PER_ALBEDO * data.lobe, 1.0), 0.0)
        self._first = self._light.sent(0, np.where(strong, 0.0, data.lobe), chance)
        self._second = self._light.sent(1, data.lobe, chance)

    def light_samples(self, cells: int) -> int:
        """See `Arrival`."""
        return _LIGHT_SAMPLES

    def arriving(self, begin: Begin, rays: int, seed: int) -> tuple[Any, Any]:
        """See `Arrival`."""
        number = dr.arange(mi.UInt32, rays)
        start = begin(number)
        hit = self._built.ray_intersect_preliminary(start.ray, active=start.active)
        color, chance, known = self._looked_up(start, hit)
        glazed = self._glazed(start.ray, hit, start.active)
        color = dr.select(glazed, 0.0, color)
        draw: Any = mi.sample_tea_float32
        salt = dr.opaque(mi.UInt32, (seed ^ _CHANCE_SALT) & 0xFFFFFFFF)
        left = start.active & ~glazed & (~known | (draw(number, salt, TEA_ROUNDS) < chance))
        dr.eval(color, left, glazed, hit)
        straight = mi.Color3f(*(dr.zeros(mi.Float, rays) for _ in range(3)))
        rest, active = _gathered(left)
        met, onto = dr.gather(type(hit), hit, rest), begin(rest)
        onto.active &= active
        self._once(onto, met, RaySums(straight, color, rest), seed)
        if self._around.index.panes is not None:
            rest, active = _gathered(glazed)
            onto = begin(rest)
            sampler = random_numbers(seed ^ _GLAZED_SALT, dr.width(rest))
            follow(
                self._around,
                sampler,
                onto.ray,
                UncountedSums(straight, color, rest),
                active=onto.active & active,
                begun=(onto.at, onto.density),
            )
        return straight, color

    def _glazed(self, ray: Any, hit: Any, active: Any) -> Any:
        """Whether rays meet a pane before anything else."""
        if self._around.index.panes is None:
            return mi.Bool(False) & active
        end = dr.select(hit.is_valid(), hit.t, dr.inf)
        return active & dr.any(self._around.index.through(ray, active, end) < 1.0)

    def _looked_up(self, start: Start, hit: Any) -> tuple[Any, Any, Any]:
        """What rays meet sends diffusely, the chance of its lobe, and whether that is known."""
        meets = start.active & hit.is_valid()
        met = self._light.meet(start.ray, hit, meets)
        known = met.known & ~met.emits & (hit.t > _NEAREST_PER_SIZE * self._light.size)
        sent = dr.gather(mi.Vector4f, self._first, met.surfel, known)
        return mi.Color3f(sent.x, sent.y, sent.z), sent.w, known

    def _once(self, start: Start, hit: Any, sums: "RaySums", seed: int) -> None:
        """Rays that are followed: what they meet is scattered once, and then looked up."""
        around, built, ray = self._around, self._built, start.ray
        sampler = random_numbers(seed ^ _ONCE_SALT, dr.width(ray))
        _, chance, counted = self._looked_up(start, hit)
        si = hit.compute_surface_interaction(ray, mi.RayFlags.All, start.active)
        sums.straight(self._emitted(si, start.at, start.density, start.active), start.active)
        # 1. Light that is looked for; of what has been looked up only the lobe is asked.
        onwards = start.active & si.is_valid()
        onwards &= around.depth > 1
        matter = around.materials(si, around.tabulated(si.shape, onwards))
        full: Any = dr.select(counted, mi.Float(0.0), mi.Float(1.0))
        reflection = Reflection.of(matter, si, 1.0, full, full)
        to, incident = built.sample_emitter_direction(si, sampler.next_2d(), True, onwards)
        local = si.to_local(to.d)
        value, pdf = reflection.value(reflection.view.frame.to_local(local), local)
        throughput = dr.select(counted, dr.rcp(chance), 1.0)
        lit = onwards & (to.pdf > 0.0)
        incident *= around.index.through(si.spawn_ray_to(to.p), lit)
        share = dr.select(to.delta, 1.0, power_heuristic(to.pdf, pdf))
        sums.scattered(throughput * value * incident * share, lit)
        # 2. One direction, and what it meets.
        wo, _ = reflection.direction(sampler.next_1d(), sampler.next_2d())
        turned = reflection.view.frame.to_world(wo)
        value, drawn = reflection.value(wo, turned)
        onwards &= (drawn > 0.0) & (dr.max(value) > 0.0)
        weight = throughput * value / dr.select(onwards, drawn, 1.0)
        ray = si.spawn_ray(si.to_world(turned))
        hit = built.ray_intersect_preliminary(ray, active=onwards)
        reach = dr.select(hit.is_valid(), hit.t, dr.inf)
        weight *= around.index.through(ray, onwards, reach)
        end = hit.compute_surface_interaction(ray, mi.RayFlags.All, onwards)
        sums.scattered(weight * self._emitted(end, si, drawn, onwards), onwards)
        meets = onwards & hit.is_valid()
        met = self._light.meet(ray, hit, meets)
        sent = dr.gather(mi.Vector4f, self._second, met.surfel, met.known)
        known = met.known & (sent.w == 0.0) & (hit.t > _NEAREST_SECOND_PER_SIZE * self._light.size)
        sums.scattered(weight * mi.Color3f(sent.x, sent.y, sent.z), known)
        # 3. What is still not known is followed as any path is.
        left = meets & ~known
        dr.eval(left, ray.o, ray.d, weight)
        rest, active = _gathered(left)
        self._onwards(ray, weight, rest, active, sums.part(rest), seed)

    def _onwards(
        self, ray: Any, weight: Any, rest: Any, active: Any, sums: "RaySums", seed: int
    ) -> None:
        """Some of the rays that have been scattered once, which carry a weight."""
        sampler = random_numbers(seed ^ _ONWARDS_SALT, dr.width(rest))
        onto = mi.Ray3f(dr.gather(mi.Point3f, ray.o, rest), dr.gather(mi.Vector3f, ray.d, rest))
        elsewhere = dr.opaque(mi.UInt32, self._around.index.elsewhere)
        before = Prefix(dr.gather(mi.Color3f, weight, rest), mi.UInt32(1), elsewhere)
        follow(self._around, sampler, onto, sums, active=active, prefix=before)

    def _emitted(self, si: Any, before: Any, density: Any, active: Any) -> Any:
        """What lamps or the sky send straight, weighted against samples of them."""
        emitter = si.emitter(self._built)
        emits = active & (emitter != None)  # noqa: E711
        ds = mi.DirectionSample3f(self._built, si, before)
        other = self._built.pdf_emitter_direction(before, ds, emits)
        return dr.select(emits, emitter.eval(si, emits) * power_heuristic(density, other), 0.0)


class RaySums:
    """Sums of what comes along some of many rays.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        straight: A colour for each of all rays, to which is added what lights send straight.
        scattered: The same of what surfaces send.
        rays: The numbers of the rays that threads are for.
    """

    def __init__(self, straight: Any, scattered: Any, rays: Any) -> None:
        self._planes, self._rays = (straight, scattered), rays

    def part(self, threads: Any) -> "RaySums":
        """The same sums for some of the threads, by their numbers."""
        return RaySums(*self._planes, dr.gather(mi.UInt32, self._rays, threads))

    def straight(self, value: Any, active: Any) -> None:
        """Add what lights send straight."""
        self._add(self._planes[0], value, active)

    def scattered(self, value: Any, active: Any) -> None:
        """Add what surfaces send."""
        self._add(self._planes[1], value, active)

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """See `orusd_mitsuba.transport.path_tracing.Accumulator`; all that paths bring later."""
        self.scattered(value, active)

    def _add(self, color: Any, value: Any, active: Any) -> None:
        for channel in range(3):
            dr.scatter_reduce(
                dr.ReduceOp.Add,
                color[channel],
                value[channel],
                self._rays,
                active,
                mode=dr.ReduceMode.NoConflicts,
            )


class UncountedSums(RaySums):
    """The same of paths that are not counted yet."""

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """See `RaySums.add`."""
        self.straight(value, active & (scatterings == 0))
        self.scattered(value, active & (scatterings > 0))


def _gathered(left: Any) -> tuple[Any, Any]:
    """The numbers of those that are left, and which of these are: two are always there.

    For one thread, or for none, other code would be compiled.
    """
    some = dr.arange(mi.UInt32, dr.width(left)) < 2
    found: Any = dr.compress(left | some)
    return found, dr.gather(mi.Bool, left, found)


class SurfelHit:
    """What rays meet.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Attributes:
        surfel: Its number.
        known: Whether there is one.
        emits: Whether the surface is a lamp's.
        foreign: Whether it is one that the cache does not know.
    """

    def __init__(self, surfel: Any, known: Any, emits: Any, foreign: Any) -> None:
        self.surfel, self.known, self.emits, self.foreign = surfel, known, emits, foreign


class SurfelLight:
    """Finds surfels along rays, and what they send.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene.
        data: What `filling.fill` made.
        tabulated: (patches,) whether each has a row in the table of materials.

    Attributes:
        size: Edge of a surfel, metres.
    """

    def __init__(self, scene: Scene, built: Any, data: CacheData, tabulated: Any) -> None:
        self._data = data
        self._index = SurfelIndex(scene, built, data.table.size_m, data.table)
        self.size = self._index.size
        a, b, c = np.moveaxis(scene.triangles.corners, 1, 0)
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        emits = np.array([patch.radiance is not None for patch in scene.patches], dtype=bool)
        flags = emits * np.uint32(_EMITS) | ~tabulated * np.uint32(_FOREIGN)
        pieces = scene.triangles.pieces.astype(np.uint32)
        pieces |= np.repeat(flags.astype(np.uint32), np.diff(scene.offsets))
        rows = np.column_stack([normals.astype(np.float32), pieces.view(np.float32)])
        self._triangles = mi.Float(aligned(rows))

    def meet(self, ray: Any, hit: Any, active: Any) -> SurfelHit:
        """The surfels that rays meet.

        Args:
            ray: The rays.
            hit: Preliminary intersections.
            active: Which meet anything.
        """
        row = self._index.triangle(hit.shape, hit.prim_index, active)
        triangle = dr.gather(mi.Vector4f, self._triangles, row, active)
        piece: Any = dr.reinterpret_array(mi.UInt32, triangle.w)
        normal = mi.Vector3f(triangle.x, triangle.y, triangle.z)
        normal = dr.select(dr.dot(normal, ray.d) <= 0.0, normal, -normal)
        emits = active & ((piece & _EMITS) != 0)
        foreign = active & ((piece & _FOREIGN) != 0)
        asked = active & ~foreign
        surfel, known = self._index.find_at(ray(hit.t), normal, piece & (_FOREIGN - 1), asked)
        return SurfelHit(surfel, known, emits, foreign)

    def sent(self, scattered: int, lobes: Floats, last: Floats) -> Any:
        """A table of what surfels send on.

        What of them goes by lobes is taken as even: what a lobe reflects of even light, times what
        the surfel receives in the mean. All directions together that is right.

        Args:
            scattered: How often light is scattered after it has left the surfel, at most less than
                the cache has been filled for.
            lobes: (N,) of each surfel's lobe, luminance.
            last: (N,) a number that is found beside it.
        """
        received = self._data.irradiance
        if scattered >= received.shape[1]:
            return mi.Float(aligned(np.zeros((len(last), 4), dtype=np.float32)))
        irradiance = received[:, scattered].sum(axis=1)
        albedo = self._data.reflected + lobes[:, None]
        sent = albedo * irradiance + self._data.passed * irradiance[self._data.behind]
        table = np.column_stack([sent / np.float32(np.pi), last]).astype(np.float32)
        return mi.Float(aligned(table))
