"""What rays meet: surfaces that stop them, and what emits on the way there."""

from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi

from openrooms_usd.render.scene.arrays import Scene
from openrooms_usd.render.scene.sources import Source
from orusd_mitsuba.complete.accumulator import WholeAccumulator
from orusd_mitsuba.complete.first_surface import FirstSurface
from orusd_mitsuba.complete.light_samples import LightSamples
from orusd_mitsuba.complete.matter import SceneMatter
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
        self.clear = any(patch.surface.opacity != 1.0 for patch in scene.patches)


class Emitted:
    """Counts what the camera's rays meet, in full."""

    def __init__(self, sums: WholeAccumulator) -> None:
        self._sums = sums

    def __call__(self, met: Any, ray: Any, light: Any, radiance: Any, active: Any) -> None:
        """Count it."""
        self._sums.emitted(radiance, light, active)


class Straight:
    """Counts what directions from a first surface meet, against the light samples there."""

    def __init__(
        self, scene: CompleteScene, at: FirstSurface, density: Any, weight: Any, sink: Accumulator
    ) -> None:
        self._lights, self._at = scene.lights, at
        self._density, self._weight, self._sink = density, weight, sink

    def __call__(self, met: Any, ray: Any, light: Any, radiance: Any, active: Any) -> None:
        """Count it by its weight."""
        rivals = self._lights.rivals(self._at.si, met, ray, self._density, light, active)
        value = self._weight * radiance / (1.0 + rivals)
        self._sink.add(value, light, mi.UInt32(1), active)


@dr.syntax
def meet(
    scene: CompleteScene, sampler: Any, ray: Any, crossed: Any, active: Any, met: Any
) -> tuple[Any, Any, Any, Any]:
    """Follow rays to the surfaces that stop them; clear ones are passed by chance.

    Args:
        scene: What there is.
        sampler: Random numbers.
        ray: The rays.
        crossed: The openings that were crossed before.
        active: Which to follow.
        met: Called with all that emits on the way.

    Returns:
        The last rays, what stopped them, the openings that they crossed, and how likely each was
        to be stopped.
    """
    ray = mi.Ray3f(ray)
    si = scene.built.ray_intersect(ray, active)
    crossed = _emission(scene, ray, si, crossed, active, met)
    stopped = mi.Float(1.0)
    if dr.hint(scene.clear, mode="scalar"):
        stopped = 1.0 - si.bsdf().eval_null_transmission(si, active)[1]
        passes = active & si.is_valid() & (sampler.next_1d() >= stopped)
        while passes:
            ray = si.spawn_ray(ray.d)
            si = scene.built.ray_intersect(ray, passes)
            crossed = _emission(scene, ray, si, crossed, passes, met)
            stopped = 1.0 - si.bsdf().eval_null_transmission(si, passes)[1]
            passes = passes & si.is_valid() & (sampler.next_1d() >= stopped)
    return ray, si, crossed, stopped


def _emission(scene: CompleteScene, ray: Any, si: Any, crossed: Any, active: Any, met: Any) -> Any:
    """Count what the rays meet, and give what they have crossed up to there."""
    hit = si.is_valid()
    end = dr.select(hit, si.t, dr.inf)
    crossed = dr.select(active, scene.index.crossed(ray.o, ray.d, end, crossed), crossed)
    emitter = si.emitter(scene.built)
    emits = active & (emitter != None)  # noqa: E711
    light = dr.select(hit, scene.index.of_shape(si.shape, emits & hit), crossed)
    met(si, ray, light, emitter.eval(si, emits), emits)
    return crossed


@dr.syntax
def meet_unoccluded(
    scene: CompleteScene, at: FirstSurface, direction: Any, density: Any, active: Any,
    sums: WholeAccumulator,
) -> None:  # fmt: skip
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
            sums.unoccluded(dr.pi * found, lamp, hit)
            ray = si.spawn_ray(direction)
            left = hit
