"""All channels of light of a camera's pictures from one set of first hits and light samples.

At the first surface three techniques look for direct light. One is a sample of every light, with
one shadow ray for irradiance, diffuse reflection and the lobe alike. One is a direction by the
cosine, and one a direction by the rest of the surface's scattering. The power heuristic (Veach
1997) combines the first with the second for what is received, and with the third for the rest. What
the surfaces scatter that the two directions meet comes from a `ScatteredLight`. Every sum adds the
same numbers by light and by kind, so they agree but for rounding.
"""

from copy import copy
from dataclasses import dataclass
from typing import Any, Final, Self

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.complete.accumulator import (
    Mirrored,
    Received,
    Reflected,
    SplitAccumulator,
    WholeAccumulator,
    pictures,
    pictures_of,
    rows_of,
)
from orusd_mitsuba.complete.first_surface import FirstSurface
from orusd_mitsuba.complete.meeting import (
    Arrival,
    CompleteScene,
    Emitted,
    Straight,
    meet,
    meet_unoccluded,
)
from orusd_mitsuba.transport.bands import Band, BandedIntegrator
from orusd_mitsuba.transport.lattice import PixelLattice
from orusd_mitsuba.transport.path_tracing import Accumulator, Prefix
from orusd_mitsuba.transport.paths import Paths
from orusd_mitsuba.transport.scattered import ScatteredLight

# Sums that one batch may keep, 4 bytes each.
_MOST_SUMS: Final = 1 << 26
# Threads that a batch shall have, as far as there are samples: fewer leave processors idle.
_THREADS: Final = 1 << 17
# Samples a pixel of a batch: it cannot be stopped in between.
_MOST_SAMPLES: Final = 256
# The part of the paths that follow the rest, where only one direction of a sample is followed on.
_LEAST_SHARE_OF_REST: Final = 0.2
_MOST_SHARE_OF_REST: Final = 0.75
# Segments of a path that is scattered once.
_DEPTH_OF_ONE_BOUNCE: Final = 2
# Keep random numbers apart.
_PIXEL_SALT, _LENS_SALT, _COSINE_SALT, _REST_SALT = 1, 2, 3, 4


@dataclass(frozen=True)
class RequestedOutputs:
    """Which parts a picture is made for; what is left out costs nothing.

    Attributes:
        by_light: Whether to split by light.
        rest: Whether what surfaces scatter but for Lambert's reflection is wanted.
        unoccluded: Whether light is wanted as if nothing stood in its way.
        guides: Whether `accumulator.GUIDES` are wanted.
    """

    by_light: bool = True
    rest: bool = True
    unoccluded: bool = True
    guides: bool = False


class CompleteIntegrator(BandedIntegrator):
    """Renders batches of a camera: `accumulator.ONCE`, `accumulator.OF_LIGHT`, and `GUIDES`.

    Args:
        scene: What it sees.
        scattered: What surfaces scatter on.
        camera: The pinhole or lens.
        width: Pixels.
        height: Pixels.
        depth: At most this many segments of a path.
        paths: How what panes mirror is followed; None where there are no panes.
        wanted: What it is for.

    Attributes:
        lights: How many lights are told apart; None where they are not.
        guided: Whether the last pictures are `accumulator.GUIDES`.
    """

    def __init__(
        self,
        scene: CompleteScene,
        scattered: ScatteredLight,
        camera: PinholeCamera,
        width: int,
        height: int,
        depth: int,
        wanted: RequestedOutputs = RequestedOutputs(),
        paths: Paths | None = None,
    ) -> None:
        self._paths = paths
        self._scene, self._scattered = scene, scattered
        self._depth, self._wanted = depth, wanted
        self.lights = scene.index.count if wanted.by_light else None
        self.guided = wanted.guides
        planes = pictures_of(self.lights, self.guided)
        super().__init__(camera, width, height, scene.origin, planes)

    def _fit(self, height: int, width: int) -> None:
        super()._fit(height, width)
        # Sums are by strand, not by sample.
        self.capacity = _MOST_SUMS // (3 * rows_of(self.lights, self.guided))
        self.most = _MOST_SAMPLES

    def sparse(self, pixels: NDArray[np.uint32]) -> Self:
        """See `BandedIntegrator`; without guides: such pixels have no neighbours.

        They are summed all the same, so that it is the same code as of the picture.
        """
        found = super().sparse(pixels)
        found.guided, found.planes = False, pictures_of(self.lights)
        return found

    def strips(self, samples: int) -> list[slice]:
        """Rows to render at once: of however many samples."""
        return super().strips(1)

    def most_in(self, rows: slice) -> int:
        """Samples of each pixel that one batch of a strip may have."""
        return self.most

    def _band(self, band: Band) -> Floats:
        pixels = band.width * band.rows
        strands = max(1, min(band.samples, min(_THREADS, self.capacity) // pixels))
        threads = Band(self, band.where, strands, band.seed)
        sums = WholeAccumulator(threads.paths, self.lights, guided=self._wanted.guides)
        _take_samples(self, threads, threads.sampler(), band.samples, sums)
        means = threads.means(sums.entries) * np.float32(strands / band.samples)
        found = pictures(means, self.lights)[: self.planes]
        return np.ascontiguousarray(np.moveaxis(found, 1, 3))

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
        emitted = Emitted(sums)
        crossed = dr.opaque(mi.UInt32, self._scene.index.elsewhere)
        seen = meet(self._scene, sampler, ray, crossed, mi.Bool(True), emitted, mirrors=False)
        si, active = seen.si, seen.si.is_valid()
        if self._depth < _DEPTH_OF_ONE_BOUNCE:
            return
        if self._wanted.rest and self._scene.index.panes is not None:
            self._in_panes(ray, dr.select(active, dr.norm(si.p - ray.o), dr.inf), sampler, sums)
        at = FirstSurface(self._scene.matter, si, active, seen.crossed, seen.through)
        self._straight(at, numbers, sums)
        cosine = self._by_cosine(at, numbers, sampler, sums)
        onwards = Received(sums, at, "indirect")
        if not self._wanted.rest:
            self._go_on(cosine, sampler, onwards)
            return
        rest = self._by_rest(at, numbers, sampler, sums)
        others = Reflected(sums, "indirect")
        if self._scattered.is_cheap:
            self._go_on(cosine, sampler, onwards)
            self._go_on(rest, sampler, others)
        else:
            which, either = _either(at, cosine, rest, sampler.next_1d())
            self._go_on(either, sampler, SplitAccumulator(which, others, onwards))

    def _in_panes(self, ray: Any, end: Any, sampler: Any, sums: WholeAccumulator) -> None:
        """What the camera sees mirrored in panes; each sample also looks straight through them."""
        index = self._scene.index
        assert index.panes is not None and self._paths is not None
        weight, onto, found = index.panes.mirror(ray, end, sampler, mi.Bool(True))
        before = Prefix(weight, mi.UInt32(1), mi.UInt32(index.elsewhere), counted=False)
        self._paths.follow(sampler, onto, Mirrored(sums), active=found, prefix=before)

    def _go_on(self, by: "_Arrival", sampler: Any, sums: Accumulator) -> None:
        self._scattered.add(
            sampler, by.ray, by.si, by.weight, by.scatterings, by.crossed, sums, by.active
        )

    def _straight(self, at: FirstSurface, numbers: PixelLattice, sums: WholeAccumulator) -> None:
        """A sample of every light, each with one shadow ray."""
        scene, wanted = self._scene, self._wanted

        def found(
            light: Any,
            ray: Any,
            direction: Any,
            incident: Any,
            density: Any,
            rivals: Any,
            active: Any,
        ) -> None:
            cosine = at.cosine(direction)
            incident = incident * scene.index.lit(light, at.si.shape, active)
            lux = incident * cosine / (rivals + dr.square(cosine * dr.inv_pi / density))
            sent = mi.Color3f(0.0)
            if wanted.rest:
                rest, other = at.rest(direction)
                sent = incident * rest / (rivals + dr.square(other / density))
            active = active & (dr.any(lux != 0.0) | dr.any(sent != 0.0))
            if wanted.unoccluded:
                sums.unoccluded(lux, light, active)
            seen = scene.between.unblocked(ray, active)
            active = active & dr.any(seen > 0.0)
            sums.received(lux * seen, at, "direct", light, active)
            if wanted.rest:
                sums.reflected(sent * seen, "direct", light, active)

        scene.lights.draw(at.si, at.crossed, numbers, at.active, found)

    def _by_cosine(
        self, at: FirstSurface, numbers: PixelLattice, sampler: Any, sums: WholeAccumulator
    ) -> "_Arrival":
        direction = at.sample_cosine(numbers.pair(_COSINE_SALT, 1))
        density = at.cosine(direction) * dr.inv_pi
        active = at.active & (density > 0.0)
        if self._wanted.unoccluded:
            meet_unoccluded(self._scene, at, direction, density, active, sums)
        weight = mi.Color3f(1.0)
        once, again = Received(sums, at, "direct"), Received(sums, at, "indirect")
        found = self._follow(at, direction, density, weight, active, sampler, once, again)
        sums.guide(at, found.active, dr.norm(found.si.p - at.si.p))
        return found

    def _by_rest(
        self, at: FirstSurface, numbers: PixelLattice, sampler: Any, sums: WholeAccumulator
    ) -> "_Arrival":
        which, where = numbers.single(_REST_SALT), numbers.pair(_REST_SALT, 1)
        direction = at.sample_rest(which, where)
        value, density = at.rest(direction)
        active = at.active & (density > 0.0) & dr.any(value != 0.0)
        weight = dr.select(active, value / dr.select(active, density, 1.0), 0.0)
        once, again = Reflected(sums, "direct"), Reflected(sums, "indirect")
        found = self._follow(at, direction, density, weight, active, sampler, once, again)
        sums.guide_lobe(at, found.active, dr.norm(found.si.p - at.si.p))
        return found

    def _follow(
        self,
        at: FirstSurface,
        direction: Any,
        density: Any,
        weight: Any,
        active: Any,
        sampler: Any,
        once: Accumulator,
        again: Accumulator,
    ) -> "_Arrival":
        """Count what directions meet straight against the light samples; say where they end."""
        scene = self._scene
        # A pane that mirrors has scattered, too.
        mirrors = scene.index.panes is not None and self._depth > _DEPTH_OF_ONE_BOUNCE
        met = Straight(scene, at, density, weight, once, again if mirrors else None)
        found = meet(scene, sampler, at.si.spawn_ray(direction), at.crossed, active, met)
        return _Arrival(found, weight * found.through / found.stopped, active)


class _Arrival:
    """Where directions from first surfaces have led, and what they carry there.

    No dataclass: Dr.Jit would carry its arrays through loops.
    """

    def __init__(self, found: Arrival, weight: Any, active: Any) -> None:
        self.ray, self.si, self.crossed = found.ray, found.si, found.crossed
        self.scatterings = dr.select(found.turned, mi.UInt32(2), mi.UInt32(1))
        self.weight, self.active = weight, active & found.si.is_valid()

    def replaced(self, which: Any, other: "_Arrival", weight: Any) -> "_Arrival":
        """The other one where that is meant, and what both then carry."""
        found = copy(self)
        for name in ("ray", "si", "crossed", "scatterings", "active"):
            setattr(found, name, dr.select(which, getattr(other, name), getattr(self, name)))
        found.weight = weight
        return found


def _either(
    at: FirstSurface, cosine: _Arrival, rest: _Arrival, choice: Any
) -> tuple[Any, _Arrival]:
    """One of two arrivals, by about what each brings to the picture; whether it is the rest's."""
    glossy, diffuse = mi.luminance(rest.weight), mi.luminance(at.albedo)
    share: Any = glossy / dr.maximum(glossy + diffuse, 1e-6)
    share = dr.clip(share, _LEAST_SHARE_OF_REST, _MOST_SHARE_OF_REST)
    share = dr.select(rest.active, dr.select(cosine.active, share, 1.0), 0.0)
    which = choice < share
    weight = dr.select(which, rest.weight / share, cosine.weight / (1.0 - share))
    return which, cosine.replaced(which, rest, weight)


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
