"""What rays meet: surfaces that stop them, and what emits on the way there."""

from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi

from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.sources import Source
from orusd_mitsuba.complete.accumulator import WholeAccumulator
from orusd_mitsuba.complete.first_surface import FirstSurface
from orusd_mitsuba.complete.light_samples import LightSamples
from orusd_mitsuba.complete.matter import SceneMatter
from orusd_mitsuba.direct.receiver import Between
from orusd_mitsuba.plugins.build import Builder
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import Accumulator


class CompleteScene:
    """What the integrators of all cameras of a scene share.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene, its shapes in the order of the patches.
        builder: What made it.
        sources: Its lights.
        index: The same for arrays of rays.

    Attributes:
        built: See above.
        index: See above.
        origin: (3,) the point of the world that is Mitsuba's origin.
        matter: What surfaces are made of.
        lights: Samples of every light.
        clear: Whether any surface of the scene lets light straight through.
        between: What stands in the way of light.
    """

    def __init__(
        self,
        scene: Scene,
        built: Any,
        builder: Builder,
        sources: Sequence[Source],
        index: LightIndex,
    ) -> None:
        self.built, self.index, self.origin = built, index, scene.origin
        self.matter = SceneMatter(scene, built, builder)
        self.lights = LightSamples(scene, built, sources, index)
        self.clear = any(patch.surface.lets_through for patch in scene.patches)
        self.between = Between(built, self.clear, index)


class Emitted:
    """Counts what the camera's rays meet, in full."""

    def __init__(self, sums: WholeAccumulator) -> None:
        self._sums = sums

    def __call__(
        self, met: Any, ray: Any, light: Any, radiance: Any, turned: Any, active: Any
    ) -> None:
        """Count it."""
        self._sums.emitted(radiance, light, active)


class Straight:
    """Counts what directions from a first surface meet, against the light samples there.

    Args:
        scene: What there is.
        at: The surfaces.
        density: Of the directions.
        weight: What they carry.
        once: Receives what was scattered at the surface alone.
        again: Receives what a pane has mirrored before, which no light sample finds; None where
            that is not wanted.
    """

    def __init__(
        self,
        scene: CompleteScene,
        at: FirstSurface,
        density: Any,
        weight: Any,
        once: Accumulator,
        again: Accumulator | None,
    ) -> None:
        self._lights, self._at, self._index = scene.lights, at, scene.index
        self._density, self._weight, self._once, self._again = density, weight, once, again

    def __call__(
        self, met: Any, ray: Any, light: Any, radiance: Any, turned: Any, active: Any
    ) -> None:
        """Count it by its weight."""
        value, straight = self._weight * radiance, active & ~turned
        rivals = self._lights.rivals(self._at.si, met, ray, self._density, light, straight)
        lit = self._index.lit(light, self._at.si.shape, straight)
        self._once.add(value * lit / (1.0 + rivals), light, mi.UInt32(1), straight)
        if self._again is not None:
            self._again.add(value, light, mi.UInt32(2), active & turned)


class Arrival:
    """Where rays were stopped, and what they carry there.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Attributes:
        ray: The last ones.
        si: What stopped them.
        crossed: The openings that were crossed on the way.
        stopped: How likely each was to be stopped.
        through: What panes have left, a colour.
        turned: Whether a pane has mirrored them.
    """

    def __init__(
        self, ray: Any, si: Any, crossed: Any, stopped: Any, through: Any, turned: Any
    ) -> None:
        self.ray, self.si, self.crossed, self.stopped = ray, si, crossed, stopped
        self.through, self.turned = through, turned


@dr.syntax
def meet(
    scene: CompleteScene,
    sampler: Any,
    ray: Any,
    crossed: Any,
    active: Any,
    met: Any,
    mirrors: bool = True,
) -> Arrival:
    """Follow rays to the surfaces that stop them; clear ones are passed by chance.

    Args:
        scene: What there is.
        sampler: Random numbers.
        ray: The rays.
        crossed: The openings that were crossed before.
        active: Which to follow.
        met: Called with all that emits on the way.
        mirrors: Whether panes may turn rays round, by chance; else these go straight through.
    """
    ray, si = mi.Ray3f(ray), dr.zeros(mi.SurfaceInteraction3f)
    stopped, through, turned = mi.Float(1.0), mi.Color3f(1.0), mi.Bool(False)
    if dr.hint(not scene.clear and scene.index.panes is None, mode="scalar"):
        si = scene.built.ray_intersect(ray, active)
        crossed = _emission(scene, ray, si, dr.inf, crossed, through, turned, active, met)
        return Arrival(ray, si, crossed, stopped, through, turned)
    left, crossed = mi.Bool(active), mi.UInt32(crossed)
    while left:
        si = scene.built.ray_intersect(ray, left)
        end = dr.select(si.is_valid(), si.t, dr.inf)
        passed, here, onto, end = scene.index.meet_panes(ray, end, sampler, left, mi.Bool(mirrors))
        through *= passed
        straight = left & ~here
        crossed = _emission(scene, ray, si, end, crossed, through, turned, straight, met)
        passes = mi.Bool(False)
        if dr.hint(scene.clear, mode="scalar"):
            stopped = 1.0 - si.bsdf().eval_null_transmission(si, straight)[1]
            passes = straight & si.is_valid() & (sampler.next_1d() >= stopped)
        ray = dr.select(here, onto, dr.select(passes, si.spawn_ray(ray.d), ray))
        turned |= here
        left = left & (here | passes)
    return Arrival(ray, si, crossed, stopped, through, turned)


def _emission(
    scene: CompleteScene,
    ray: Any,
    si: Any,
    end: Any,
    crossed: Any,
    through: Any,
    turned: Any,
    active: Any,
    met: Any,
) -> Any:
    """Count what the rays meet, and give what they have crossed up to there."""
    hit = si.is_valid()
    end = dr.minimum(dr.select(hit, si.t, dr.inf), end)
    crossed = scene.index.crossed(ray.o, ray.d, end, crossed)
    emitter = si.emitter(scene.built)
    emits = active & (emitter != None)  # noqa: E711
    light = dr.select(hit, scene.index.of_shape(si.shape, emits & hit), crossed)
    met(si, ray, light, emitter.eval(si, emits) * through, turned, emits)
    return crossed


@dr.syntax
def meet_unoccluded(
    scene: CompleteScene,
    at: FirstSurface,
    direction: Any,
    density: Any,
    active: Any,
    sums: WholeAccumulator,
) -> None:
    """All that a direction of the cosine would meet without what stands in its way."""
    lights, ray = scene.lights, at.si.spawn_ray(direction)
    if dr.hint(lights.sky is not None, mode="scalar"):
        light = scene.index.crossed(ray.o, direction, mi.Float(dr.inf), at.crossed)
        lux = dr.pi * lights.from_sky(at.si, direction, density, light, active)
        sums.unoccluded(lux, light, active)
    if dr.hint(len(lights.faces) > 0, mode="scalar"):
        left = mi.Bool(active)
        while left:
            si = lights.faces.alone.ray_intersect(ray, left)
            hit = left & si.is_valid()
            lamp, found = lights.from_lamp(at.si, si, direction, density, hit)
            found *= scene.index.lit(lamp, at.si.shape, hit)
            sums.unoccluded(dr.pi * found, lamp, hit)
            ray = si.spawn_ray(direction)
            left = hit
