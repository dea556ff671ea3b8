"""A sample of every light, as seen from surface points, and how densely it takes directions.

A point on each lamp, each sun, a direction by the surroundings' own brightness, and one through
each opening. The last two find the same light, so each is weighted against the other: by the power
heuristic (Veach 1997), whose terms are ratios, because squares of densities overflow.
"""

from collections.abc import Sequence
from typing import Any, Final, Protocol

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.sources import Source
from orusd_mitsuba.direct.lamp_faces import LampFaces
from orusd_mitsuba.direct.rectangles import Rectangles
from orusd_mitsuba.plugins.sun_disk import towards
from orusd_mitsuba.transport.lattice import PixelLattice
from orusd_mitsuba.transport.light_index import LightIndex, registered

# What is nearer to a face's plane, relative to the numbers that say where it is, is in it: they are
# in single precision.
_IN_PLANE_HEIGHT_PER_SIZE: Final = 2.0**-22
# Keep the random numbers of techniques apart; lamps and openings add their number.
_SKY_SALT: Final = 100
_SUN_SALT: Final = 200
_LAMP_SALT: Final = 1000
_OPENING_SALT: Final = 1_000_000


class LightSampleSink(Protocol):
    """Receives light samples."""

    def __call__(
        self,
        light: Any,
        ray: Any,
        direction: Any,
        incident: Any,
        density: Any,
        rivals: Any,
        active: Any,
    ) -> None:
        """Count a sample where nothing stands in its way.

        Args:
            light: Its number.
            ray: To what is sampled, from beside the surface.
            direction: From the surface itself.
            incident: Radiance over density; of parallel light its irradiance.
            density: Over solid angle; infinite for parallel light.
            rivals: The squares of all densities that light samples take the direction with, over
                that of ``density``: at least 1.
            active: Where there is a sample.
        """
        ...


class LightSamples:
    """Samples all lights of a scene.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene, its shapes in the order of the patches.
        sources: Its lights.
        index: The same for arrays of rays.

    Attributes:
        faces: Those of all lamps.
        sky: The surroundings; None without.
    """

    def __init__(
        self, scene: Scene, built: Any, sources: Sequence[Source], index: LightIndex
    ) -> None:
        self._suns, self._index, self._built = scene.suns, index, built
        self.faces = LampFaces(scene, built, sources)
        self.sky = built.environment()
        self._openings = Rectangles(sources, scene.origin)
        # As variables, not as parts of the compiled code.
        self._lamps = dr.opaque(mi.UInt32, len(self.faces))
        self._rectangles = dr.opaque(mi.UInt32, len(self._openings))
        numbers = [int(registered(mi.ShapePtr(shape))[0]) for shape in built.shapes()]
        # First row of a shape's faces; for shapes that are not lamps one behind all of them.
        count = int(self.faces.starts[-1])
        self._count = dr.opaque(mi.UInt32, count)
        starts = np.full(max(numbers, default=0) + 1, count, dtype=np.uint32)
        row = 0
        for light in self.faces.lights:
            for patch in sources[light].patches:
                starts[numbers[patch]] = row
                row += len(scene.patches[patch].triangles)
        self._starts = mi.UInt32(starts)

    def draw(
        self, si: Any, crossed: Any, numbers: PixelLattice, active: Any, found: LightSampleSink
    ) -> None:
        """Sample every light once, the surroundings by each of their techniques.

        Args:
            si: From where.
            crossed: The opening that was crossed on the way there.
            numbers: What samples are drawn by.
            active: Where they are wanted.
            found: Receives them.
        """
        for number, sun in enumerate(self._suns):
            way, lux = towards(sun, numbers.pair(number + _SUN_SALT))
            ray = si.spawn_ray(way)
            light = self._index.crossed(ray.o, ray.d, mi.Float(dr.inf), crossed)
            found(light, ray, ray.d, lux, mi.Float(dr.inf), mi.Float(1.0), active)
        if len(self.faces):
            self._draw_lamps(si, numbers, active, found)
        if self.sky is None:
            return
        ds, _ = self.sky.sample_direction(si, numbers.pair(_SKY_SALT), active)
        light = self._index.crossed(si.p, ds.d, mi.Float(dr.inf), crossed)
        self._by_sky(si, ds.d, ds.pdf, light, active, found)
        if len(self._openings):
            self._draw_openings(si, crossed, numbers, active, found)

    @dr.syntax
    def _draw_lamps(
        self, si: Any, numbers: PixelLattice, active: Any, found: LightSampleSink
    ) -> None:
        lamp = mi.UInt32(0)
        while lamp < self._lamps:
            salt = lamp + _LAMP_SALT
            choice, within = numbers.single(salt), numbers.pair(salt)
            row, place, point = self.faces.sample(lamp, si.p, choice, within)
            to = point - si.p
            squared = dr.squared_norm(to)
            direction = to * dr.rsqrt(squared)
            turned = -dr.dot(self.faces.normal(row), direction)
            front = active & (turned > 0.0) & self._faces_lamp(si, row, point)
            density = self.faces.density(row, lamp, si.p) * squared / turned
            incident = self.faces.radiance(row, place, front, -direction) / density
            front &= density > 0.0
            light, ray = self.faces.light(lamp), si.spawn_ray_to(point)
            found(light, ray, direction, incident, density, mi.Float(1.0), front)
            lamp += 1

    @dr.syntax
    def _draw_openings(
        self, si: Any, crossed: Any, numbers: PixelLattice, active: Any, found: LightSampleSink
    ) -> None:
        row = mi.UInt32(0)
        while row < self._rectangles:
            sample = numbers.pair(row + _OPENING_SALT)
            direction, density = self._openings.sample(row, si.p, sample)
            light = self._index.crossed(si.p, direction, mi.Float(dr.inf), crossed)
            # Behind one opening there may be another, whose own samples find it.
            own = active & (density > 0.0) & (light == self._openings.light(row))
            self._by_sky(si, direction, density, light, own, found)
            row += 1

    def _by_sky(
        self, si: Any, direction: Any, density: Any, light: Any, active: Any, found: LightSampleSink
    ) -> None:
        active = active & (density > 0.0)
        towards = dr.zeros(mi.SurfaceInteraction3f, dr.width(direction))
        towards.wi = -direction
        incident = self.sky.eval(towards, active) / density
        rivals = self._sky_rivals(si, direction, density, light, active)
        found(light, si.spawn_ray(direction), direction, incident, density, rivals, active)

    def rivals(self, si: Any, met: Any, ray: Any, density: Any, light: Any, active: Any) -> Any:
        """The squares of the densities of light samples over that of a ray's direction.

        Args:
            si: From where lights are sampled.
            met: What the ray has met, a lamp or the sky.
            ray: From ``si``, perhaps by way of clear surfaces.
            density: Of its direction.
            light: Where it ends, by number.
            active: Where it meets light.
        """
        hit = met.is_valid()
        total = mi.Float(0.0)
        if len(self.faces):
            total += dr.square(self._lamp_density(si, met, ray, active & hit) / density)
        if self.sky is not None:
            sky = active & ~hit
            found = self._sky_rivals(si, ray.d, density, light, sky)
            total += dr.select(sky, found, 0.0)
        return total

    def from_sky(self, si: Any, direction: Any, density: Any, light: Any, active: Any) -> Any:
        """What the surroundings send along directions, against the light samples."""
        towards = dr.zeros(mi.SurfaceInteraction3f, dr.width(direction))
        towards.wi = -direction
        rivals = self._sky_rivals(si, direction, density, light, active)
        return self.sky.eval(towards, active) / (1.0 + rivals)

    def from_lamp(
        self, si: Any, met: Any, direction: Any, density: Any, active: Any
    ) -> tuple[Any, Any]:
        """The lamps that directions meet among `faces` alone, and the same of these.

        Args:
            si: From where.
            met: What they meet.
            direction: The directions.
            density: Of these.
            active: Where they meet any.
        """
        row = met.prim_index
        lamp = self.faces.lamp(row, active)
        turned = -dr.dot(self.faces.normal(row, active), direction)
        front = active & (turned > 0.0) & self._faces_lamp(si, row, met.p)
        by_area = self.faces.density(row, lamp, si.p, front)
        other = by_area * dr.squared_norm(met.p - si.p) / turned
        radiance = self.faces.radiance(row, self.faces.place(row, met.p), front, -direction)
        value = radiance / (1.0 + dr.square(other / density))
        return self.faces.light(lamp), dr.select(front, value, 0.0)

    def _lamp_density(self, si: Any, met: Any, ray: Any, active: Any) -> Any:
        shape: Any = dr.reinterpret_array(mi.UInt32, met.shape)
        start = dr.gather(mi.UInt32, self._starts, shape, active)
        lamp = active & (start < self._count)
        row = start + met.prim_index
        turned = -dr.dot(self.faces.normal(row, lamp), ray.d)
        squared = dr.squared_norm(met.p - si.p)
        by_area = self.faces.density(row, self.faces.lamp(row, lamp), si.p, lamp)
        front = lamp & (turned > 0.0) & self._faces_lamp(si, row, met.p)
        return dr.select(front, by_area * squared / dr.select(front, turned, 1.0), 0.0)

    def _faces_lamp(self, si: Any, row: Any, point: Any) -> Any:
        """Whether surfaces are before a face and not in its plane: a lamp does not light itself."""
        to = point - si.p
        height = -dr.dot(self.faces.normal(row), to)
        return height > _IN_PLANE_HEIGHT_PER_SIZE * (dr.norm(si.p) + dr.norm(to))

    def _sky_rivals(self, si: Any, direction: Any, density: Any, light: Any, active: Any) -> Any:
        ds = dr.zeros(mi.DirectionSample3f, dr.width(direction))
        ds.d = direction
        total = dr.square(self.sky.pdf_direction(si, ds, active) / density)
        if len(self._openings):
            total += dr.square(self._openings.density(light, si.p, direction) / density)
        return total
