"""Direct irradiance of each light, with and without occlusion, and visibility, their ratio.

The first surface is made white. There the power heuristic (Veach 1997) combines two techniques. One
is a sample of each light (a point on a lamp, a direction to the surroundings). The other is one
direction of the hemisphere by its cosine, which finds lights that are large or close. Both sums,
without and with what stands between, are over the same samples: the visibility is so a mean of
numbers in [0, 1] under common weights. For a lamp of few faces the irradiance without occlusion is
also known in closed form, and serves as a control variate.
"""

from collections.abc import Callable, Sequence
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Floats
from openrooms_usd.rendering.scene.arrays import Scene, Sun
from openrooms_usd.rendering.scene.sources import Source
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.direct.accumulator import DirectAccumulator
from orusd_mitsuba.direct.closed_form import factor
from orusd_mitsuba.direct.control_variate import PLANES_PER_LIGHT
from orusd_mitsuba.direct.lamp_faces import LampFaces
from orusd_mitsuba.direct.receiver import Between, Receiver, receive
from orusd_mitsuba.direct.rectangles import Rectangles
from orusd_mitsuba.plugins.sun_disk import towards
from orusd_mitsuba.transport.bands import Band, BandedIntegrator
from orusd_mitsuba.transport.light_index import LightIndex

White = Callable[[Any], Any]

# Faces up to which a lamp is summed in closed form, at every sample.
_MOST_CLOSED_FORM_FACES: Final = 128
# What stands in the planes of a light that has no closed form.
_NO_CLOSED_FORM: Final = -1.0


class DirectIntegrator(BandedIntegrator):
    """Renders batches of samples of a camera: every light occluded, unoccluded, and in closed form.

    A pass is for `orusd_mitsuba.direct.control_variate.finish`: four pictures a light.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene, its shapes in the order of the patches.
        sources: Its lights.
        index: The same for arrays of rays.
        first: What makes surfaces white; see `orusd_mitsuba.transport.white.white_first`.
        camera: The pinhole or lens.
        width: Pixels.
        height: Pixels.
    """

    def __init__(
        self,
        scene: Scene,
        built: Any,
        sources: Sequence[Source],
        index: LightIndex,
        first: White,
        camera: PinholeCamera,
        width: int,
        height: int,
    ) -> None:
        self._scene, self._built = scene, built
        self._index, self._first = index, first
        self._faces = LampFaces(scene, built, sources)
        sizes = np.diff(self._faces.starts)
        self._closed = [
            lamp
            for lamp in range(len(self._faces))
            if self._faces.even[lamp] and sizes[lamp] <= _MOST_CLOSED_FORM_FACES
        ]
        self._lights = index.count
        super().__init__(camera, width, height, scene.origin, PLANES_PER_LIGHT * self._lights)
        self._clear = any(patch.surface.lets_through for patch in scene.patches)
        self._between = Between(built, self._clear, index)
        self._sky = None
        if built.environment() is not None:
            self._sky = Sky(built, index, self._between, Rectangles(sources, scene.origin))

    def _band(self, band: Band) -> Floats:
        sampler = band.sampler()
        ray = band.ray(sampler.next_2d(), sampler.next_2d())
        sums = DirectAccumulator(band.paths, self._lights, len(self._closed))
        self._gather(ray, sampler, sums)
        means = band.means(sums.entries)
        whole = np.full((PLANES_PER_LIGHT, self._lights, *means.shape[1:]), _NO_CLOSED_FORM)
        whole[:2] = means[: 2 * self._lights].reshape(whole[:2].shape)
        for lamp, closed in zip(self._closed, means[2 * self._lights :], strict=True):
            light = self._faces.lights[lamp]
            whole[2, light] = closed
            whole[3, light] = _moments(sums, light, band.samples, band.rows)
        return np.moveaxis(whole.reshape(self.planes, *means.shape[1:]), 1, 3).astype(np.float32)

    def _gather(self, ray: Any, sampler: Any, sums: DirectAccumulator) -> None:
        at = receive(self._built, self._index, self._first, sampler, ray, self._clear)
        if len(self._faces):
            _from_lamps(self._between, self._faces, at, sampler, sums)
        if self._closed:
            lamps = mi.UInt32(np.array(self._closed, dtype=np.uint32))
            _in_closed_form(self._faces, lamps, len(self._closed), at, sums)
        for sun in self._scene.suns:
            self._from_sun(sun, at, sampler, sums)
        if self._sky is not None:
            self._sky.gather(at, sampler, sums)
        self._by_hemisphere(at, sampler, sums)
        if self._index.is_linked:
            self._dim(at, sums)

    def _dim(self, at: Receiver, sums: DirectAccumulator) -> None:
        """Take away what lamps do not light."""
        closed = {self._faces.lights[lamp]: row for row, lamp in enumerate(self._closed)}
        for light in self._faces.lights:
            lit = self._index.lit(mi.UInt32(light), at.si.shape, at.active)
            planes = [light, light + self._lights]
            planes += [2 * self._lights + closed[light]] if light in closed else []
            for plane in planes:
                sums.dim(plane, lit)

    def _by_hemisphere(self, at: Receiver, sampler: Any, sums: DirectAccumulator) -> None:
        direction, density = at.sample(sampler.next_2d())
        if len(self._faces):
            _meet_lamps(self._between, self._faces, at, direction, density, sums)
        if self._sky is not None:
            self._sky.add(at, direction, density, at.active & (density > 0.0), sums)

    def _from_sun(self, sun: Sun, at: Receiver, sampler: Any, sums: DirectAccumulator) -> None:
        direction, lux = towards(sun, sampler.next_2d() if sun.angle > 0.0 else None)
        light = self._index.crossed(at.si.p, direction, mi.Float(dr.inf), at.crossed)
        active = at.active & (at.cosine(direction) > 0.0)
        seen = self._between.unblocked(at.si.spawn_ray(direction), active)
        sums.add(light, lux * at.cosine(direction), seen, active)


@dr.syntax
def _from_lamps(
    between: Between, faces: LampFaces, at: Receiver, sampler: Any, sums: DirectAccumulator
) -> None:
    """A point on each lamp in turn."""
    lamp = mi.UInt32(0)
    while lamp < len(faces):
        row, place, point = faces.sample(lamp, at.si.p, sampler.next_1d(), sampler.next_2d())
        to = point - at.si.p
        squared = dr.squared_norm(to)
        direction = to * dr.rsqrt(squared)
        turned = -dr.dot(faces.normal(row), direction)
        cosine = at.cosine(direction)
        active = at.active & (squared > 0.0) & (turned > 0.0) & (cosine > 0.0)
        density = faces.density(row, lamp, at.si.p) * squared / turned
        value = faces.radiance(row, place, active, -direction) * (cosine / density)
        value *= heuristic(density, at.density(direction))
        seen = between.unblocked(at.si.spawn_ray_to(point), active)
        sums.add(faces.light(lamp), value, seen, active)
        lamp += 1


@dr.syntax
def _meet_lamps(
    between: Between,
    faces: LampFaces,
    at: Receiver,
    direction: Any,
    density: Any,
    sums: DirectAccumulator,
) -> None:
    """All faces of lamps that a direction of the hemisphere meets, one behind the other."""
    ray = at.si.spawn_ray(direction)
    active = at.active & (density > 0.0)
    while active:
        si = faces.alone.ray_intersect(ray, active)
        hit = active & si.is_valid()
        row = si.prim_index
        lamp = faces.lamp(row, hit)
        turned = -dr.dot(faces.normal(row, hit), direction)
        front = hit & (turned > 0.0)
        squared = dr.squared_norm(si.p - at.si.p)
        other = faces.density(row, lamp, at.si.p, front) * squared / turned
        value = faces.radiance(row, faces.place(row, si.p), front, -direction) * (
            at.cosine(direction) / density * heuristic(density, other)
        )
        seen = between.unblocked(at.si.spawn_ray_to(si.p), front)
        sums.add(faces.light(lamp), value, seen, front)
        ray = si.spawn_ray(direction)
        active = hit


@dr.syntax
def _in_closed_form(
    faces: LampFaces, lamps: Any, count: int, at: Receiver, sums: DirectAccumulator
) -> None:
    """All faces of those lamps that have few."""
    number = mi.UInt32(0)
    while number < count:
        row, last = faces.rows(dr.gather(mi.UInt32, lamps, number))
        total = mi.Color3f(0.0)
        while row <= last:
            share = factor(faces.corners(row), at.si.p, at.normal, at.horizon)
            total += faces.radiance(row, mi.Point2f(0.0)) * share
            row += 1
        sums.add_closed(number, total, at.active)
        number += 1


def heuristic(used: Any, other: Any) -> Any:
    """The power heuristic for two techniques, by their ratio: squares of densities overflow."""
    return dr.select(used > 0.0, dr.rcp(1.0 + dr.square(other / used)), 0.0)


def _moments(sums: DirectAccumulator, light: int, samples: int, rows: int) -> Floats:
    """(3, rows, width) means of a light's unoccluded green squared, times occluded, and 0."""
    occluded, unoccluded = (sums.green(plane) for plane in (light, light + sums.lights))
    found = [
        dr.block_sum(unoccluded * other, samples).numpy().reshape(rows, -1) / np.float32(samples)
        for other in (unoccluded, occluded)
    ]
    return np.stack([*found, np.zeros_like(found[0])])


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
