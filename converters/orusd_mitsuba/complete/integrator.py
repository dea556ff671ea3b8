"""All channels of light of a camera's pictures from one set of first hits and light samples.

At the first surface three techniques look for straight light: a sample of every light, with one
shadow ray that serves irradiance, diffuse reflection and the lobe alike; a direction by the cosine;
a direction by the rest of what the surface scatters. The power heuristic (Veach 1997) combines the
first with the second for what is received, and with the third for the rest. What the surfaces
scatter that the two directions meet comes from a `ScatteredLight`. Every sum adds the same numbers
by light and by kind, so they agree but for rounding.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.render.scene.arrays import Scene
from openrooms_usd.render.scene.sources import Source
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.complete.accumulator import Received, Reflected, WholeAccumulator, rows_of
from orusd_mitsuba.complete.first_surface import FirstSurface
from orusd_mitsuba.complete.light_samples import LightSamples
from orusd_mitsuba.complete.matter import SceneMatter
from orusd_mitsuba.direct.receiver import unblocked
from orusd_mitsuba.plugins.build import Builder
from orusd_mitsuba.transport.bands import Band, BandedIntegrator
from orusd_mitsuba.transport.lattice import PixelLattice
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import Accumulator
from orusd_mitsuba.transport.scattered import ScatteredLight

# Threads that a batch shall have, as far as there are samples: fewer leave processors idle.
_THREADS: Final = 1 << 17
# Samples a pixel of a batch: it cannot be stopped in between.
_MOST_SAMPLES: Final = 256
# Keep random numbers apart.
_PIXEL_SALT, _LENS_SALT, _COSINE_SALT, _REST_SALT = 1, 2, 3, 4


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


@dataclass(frozen=True)
class Wanted:
    """Which parts a picture is made for; what is left out costs nothing.

    Attributes:
        by_light: Whether to split by light.
        rest: Whether what surfaces scatter but for Lambert's reflection is wanted.
        unoccluded: Whether light is wanted as if nothing stood in its way.
    """

    by_light: bool = True
    rest: bool = True
    unoccluded: bool = True


class CompleteIntegrator(BandedIntegrator):
    """Renders batches of a camera: `accumulator.KINDS`, then `accumulator.OF_LIGHT`.

    Args:
        scene: What it sees.
        scattered: What surfaces scatter on.
        camera: The pinhole or lens.
        width: Pixels.
        height: Pixels.
        depth: At most this many segments of a path.
        wanted: What it is for.
    """

    def __init__(
        self,
        scene: CompleteScene,
        scattered: ScatteredLight,
        camera: PinholeCamera,
        width: int,
        height: int,
        depth: int,
        wanted: Wanted = Wanted(),
    ) -> None:
        self._scene, self._scattered = scene, scattered
        self._depth, self._wanted = depth, wanted
        self._lights = scene.index.count if wanted.by_light else None
        super().__init__(camera, width, height, scene.origin, rows_of(self._lights))

    def _fit(self, height: int, width: int) -> None:
        super()._fit(height, width)
        # Sums are by strand, not by sample.
        self.most = _MOST_SAMPLES

    def _band(self, band: Band) -> NDArray[np.float32]:
        pixels = band.width * band.rows
        strands = max(1, min(band.samples, _THREADS // pixels))
        threads = Band(self, band.top, strands, band.seed)
        sums = WholeAccumulator(threads.paths, self._lights)
        _take_samples(self, threads, threads.sampler(), band.samples, sums)
        means = threads.means(sums.entries) * np.float32(strands / band.samples)
        return np.ascontiguousarray(np.moveaxis(means, 1, 3))

    def sample(
        self, threads: Band, sampler: Any, samples: int, number: Any, sums: WholeAccumulator
    ) -> None:
        """Take one sample of each thread's pixel.

        Args:
            threads: Some for each pixel.
            sampler: Random numbers, a stream for each.
            samples: Of a pixel.
            number: Which of these each thread takes now.
            sums: Receives what is found.
        """
        pixel = dr.arange(mi.UInt32, threads.paths) // dr.opaque(mi.UInt32, threads.samples)
        numbers = PixelLattice(samples, pixel, number, threads.seed)
        ray = threads.ray(numbers.pair(_PIXEL_SALT, 2), numbers.pair(_LENS_SALT, 1))
        emitted = _Emitted(sums)
        crossed = dr.opaque(mi.UInt32, self._scene.index.elsewhere)
        _, si, crossed, _ = _meet(self._scene, sampler, ray, crossed, mi.Bool(True), emitted)
        active = si.is_valid()
        if self._depth < 2:
            return
        at = FirstSurface(self._scene.matter, si, active, crossed)
        self._straight(at, numbers, sums)
        self._by_cosine(at, numbers, sampler, sums)
        if self._wanted.rest:
            self._by_rest(at, numbers, sampler, sums)

    def _straight(self, at: FirstSurface, numbers: PixelLattice, sums: WholeAccumulator) -> None:
        """A sample of every light, each with one shadow ray."""
        scene, wanted = self._scene, self._wanted

        def found(
            light: Any, ray: Any, incident: Any, density: Any, rivals: Any, active: Any
        ) -> None:
            cosine = at.cosine(ray.d)
            lux = incident * cosine / (rivals + dr.square(cosine * dr.inv_pi / density))
            sent = mi.Color3f(0.0)
            if wanted.rest:
                rest, other = at.rest(ray.d)
                sent = incident * rest / (rivals + dr.square(other / density))
            active = active & (dr.any(lux != 0.0) | dr.any(sent != 0.0))
            if wanted.unoccluded:
                sums.unoccluded(lux, light, active)
            seen = unblocked(scene.built, scene.clear, ray, active)
            active = active & (seen > 0.0)
            sums.received(lux * seen, at, "direct", light, active)
            if wanted.rest:
                sums.reflected(sent * seen, "direct", light, active)

        scene.lights.draw(at.si, at.crossed, numbers, at.active, found)

    def _by_cosine(
        self, at: FirstSurface, numbers: PixelLattice, sampler: Any, sums: WholeAccumulator
    ) -> None:
        direction = at.sample_cosine(numbers.pair(_COSINE_SALT, 1))
        density = at.cosine(direction) * dr.inv_pi
        active = at.active & (density > 0.0)
        straight, onwards = (Received(sums, at, kind) for kind in ("direct", "indirect"))
        self._follow(at, direction, density, mi.Color3f(1.0), active, sampler, straight, onwards)
        if self._wanted.unoccluded:
            _meet_unoccluded(self._scene, at, direction, density, active, sums)

    def _by_rest(
        self, at: FirstSurface, numbers: PixelLattice, sampler: Any, sums: WholeAccumulator
    ) -> None:
        which, where = numbers.single(_REST_SALT), numbers.pair(_REST_SALT, 1)
        direction = at.sample_rest(which, where)
        value, density = at.rest(direction)
        active = at.active & (density > 0.0) & dr.any(value != 0.0)
        weight = value / dr.select(active, density, 1.0)
        straight, onwards = Reflected(sums, "direct"), Reflected(sums, "indirect")
        self._follow(at, direction, density, weight, active, sampler, straight, onwards)

    def _follow(
        self, at: FirstSurface, direction: Any, density: Any, weight: Any, active: Any,
        sampler: Any, straight: Accumulator, onwards: Accumulator,
    ) -> None:  # fmt: skip
        """What arrives along a direction: straight against the light samples, and scattered."""
        scene = self._scene
        met = _Straight(scene, at, density, weight, straight)
        ray, si, crossed, stopped = _meet(
            scene, sampler, at.si.spawn_ray(direction), at.crossed, active, met
        )
        self._scattered.add(
            sampler, ray, si, weight / stopped, mi.UInt32(1), crossed, onwards,
            active & si.is_valid(),
        )  # fmt: skip


@dr.syntax
def _take_samples(
    integrator: CompleteIntegrator,
    threads: Band,
    sampler: Any,
    samples: int,
    sums: WholeAccumulator,
) -> None:
    """All samples of each pixel, some in each of its threads."""
    count, step = (dr.opaque(mi.UInt32, many) for many in (samples, threads.samples))
    number = dr.arange(mi.UInt32, threads.paths) % step
    while number < count:
        integrator.sample(threads, sampler, samples, number, sums)
        number += step


class _Emitted:
    """Counts what the camera's rays meet, in full."""

    def __init__(self, sums: WholeAccumulator) -> None:
        self._sums = sums

    def __call__(self, met: Any, ray: Any, light: Any, radiance: Any, active: Any) -> None:
        self._sums.emitted(radiance, light, active)


class _Straight:
    """Counts what directions from a first surface meet, against the light samples there."""

    def __init__(
        self, scene: CompleteScene, at: FirstSurface, density: Any, weight: Any, sink: Accumulator
    ) -> None:
        self._lights, self._at = scene.lights, at
        self._density, self._weight, self._sink = density, weight, sink

    def __call__(self, met: Any, ray: Any, light: Any, radiance: Any, active: Any) -> None:
        rivals = self._lights.rivals(self._at.si, met, ray, self._density, light, active)
        value = self._weight * radiance / (1.0 + rivals)
        self._sink.add(value, light, mi.UInt32(1), active)


@dr.syntax
def _meet(
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
def _meet_unoccluded(
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
