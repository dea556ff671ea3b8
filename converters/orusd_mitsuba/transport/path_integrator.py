"""Pictures of a camera, each split by the number of scatterings and by light."""

from collections.abc import Callable
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.transport.bands import Band, BandedIntegrator
from orusd_mitsuba.transport.lattice import FirstDimensions
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import KINDS, PathAccumulator, Prefix
from orusd_mitsuba.transport.paths import Paths, TracedPaths

# Sets the seeds of pixels apart from those of paths.
_SHIFT_SALT: Final = 0x5EED5EED
# And those of which pane mirrors, and of paths from there.
_PANE_SALT: Final = 0x3A7E5EED
_MIRROR_SALT: Final = 0x71C35EED


class PathIntegrator(BandedIntegrator):
    """Renders batches of a camera: what was scattered never, once, more often, then each light.

    Args:
        built: The Mitsuba scene.
        index: Its lights.
        camera: The pinhole or lens.
        width: Pixels.
        height: Pixels.
        origin: (3,) the point of the world that is Mitsuba's origin.
        depth: At most this many segments of a path.
        by_light: Whether to split by light too.
        first: See `orusd_mitsuba.transport.path_tracing.trace`.
        paths: How they are followed; None: to their end.
    """

    def __init__(
        self,
        built: Any,
        index: LightIndex,
        camera: PinholeCamera,
        width: int,
        height: int,
        origin: Array,
        depth: int,
        *,
        by_light: bool = True,
        first: Callable[[Any], Any] | None = None,
        paths: Paths | None = None,
    ) -> None:
        self._built, self._index = built, index
        self._paths = paths or TracedPaths(built, index, depth)
        self._first = first
        self._lights = index.count if by_light else None
        planes = len(KINDS) + (self._lights or 0)
        super().__init__(camera, width, height, origin, planes)

    def _band(self, band: Band) -> Floats:
        sampler = band.sampler()
        pixels = band.paths // band.samples
        numbers = FirstDimensions(band.samples, band.paths, band.sampler(_SHIFT_SALT, pixels))
        ray = band.ray(numbers.pixel, sampler.next_2d())
        accumulator = PathAccumulator(band.paths, self._lights)
        self._paths.follow(
            sampler, ray, accumulator, first=self._first, numbers=numbers, looks_through=True
        )
        if self._index.panes is not None:
            self._in_panes(band, ray, accumulator)
        wanted = (
            [accumulator.kinds]
            if accumulator.lights is None
            else [accumulator.kinds, accumulator.lights]
        )
        means = np.concatenate([band.means(entries) for entries in wanted])
        return np.ascontiguousarray(np.moveaxis(means, 1, 3))

    def _in_panes(self, band: Band, ray: Any, accumulator: PathAccumulator) -> None:
        """What the camera sees mirrored in panes; each sample also looks straight through them.

        Most samples look at no pane: only the others are followed, in a row of their own.
        """
        assert self._index.panes is not None
        hit = self._built.ray_intersect_preliminary(ray)
        end = dr.select(hit.is_valid(), hit.t, dr.inf)
        chosen = band.sampler(_PANE_SALT)
        weight, onto, found = self._index.panes.mirror(ray, end, chosen, mi.Bool(True))
        dr.eval(weight, onto, found)
        which: Any = dr.compress(found)
        count = dr.width(which)
        if not count:
            return
        weight = dr.gather(mi.Color3f, weight, which)
        onto = mi.Ray3f(dr.gather(mi.Point3f, onto.o, which), dr.gather(mi.Vector3f, onto.d, which))
        crossed = mi.UInt32(self._index.elsewhere)
        before = Prefix(weight, mi.UInt32(1), crossed, counted=False)
        self._paths.follow(
            band.sampler(_MIRROR_SALT, count), onto, accumulator.part(which), prefix=before
        )
