"""Irradiance at texels of lightmaps: light that is traced from points on surfaces.

A ray that begins just above a point and heads down onto it makes its surface the first that the
path meets. That surface is white, so what it sends back tells what it receives.
"""

import time
from collections.abc import Callable
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rendering.bake.request import LIFT_M, Irradiance, IrradianceRequest, TexelPoints
from orusd_mitsuba.transport.lattice import FirstDimensions
from orusd_mitsuba.transport.path_tracing import KINDS, PathAccumulator, random_numbers
from orusd_mitsuba.transport.paths import Paths
from orusd_mitsuba.transport.sampling import ProgressiveSampler

# Sums that one batch may keep, 4 bytes each, and paths that may be in flight.
_MOST_SUMS: Final = 1 << 26
_PATHS_IN_FLIGHT: Final = 1 << 20
_SHIFT_SALT: Final = 0x5BD1E995


class TexelIntegrator:
    """Renders batches of samples of the irradiance of texels.

    Args:
        paths: How they are followed.
        lights: How many there are.
        white: Gives the white BSDF of a surface (`orusd_mitsuba.transport.white`).
        points: What the texels stand for.
        origin: (3,) the point of the world that is Mitsuba's origin.

    Attributes:
        planes: One for each light.
        size: 1, and the number of texels.
        most: Samples of each texel that one batch may have at most.
        broken: (1, texels) bool, those for which a batch gave no number.
    """

    def __init__(
        self,
        paths: Paths,
        lights: int,
        white: Callable[[Any], Any],
        points: TexelPoints,
        origin: Array,
    ) -> None:
        self._paths, self._white = paths, white
        self._points = _Points(points, origin)
        self.planes, self.size = lights, (1, len(points))
        fitting = min(_PATHS_IN_FLIGHT, _MOST_SUMS // (3 * (lights + len(KINDS))))
        self._texels = max(1, min(len(points), fitting))
        self.most = max(1, fitting // self._texels)
        self.broken = np.zeros(self.size, dtype=bool)

    def __call__(self, samples: int, seed: int) -> Floats:
        """Render one batch; equal seeds give equal bits.

        Returns:
            (lights, 1, texels, 3) lux.
        """
        return self.strip(slice(0, 1), samples, seed)

    def strips(self, samples: int) -> list[slice]:
        """The only row."""
        return [slice(0, 1)]

    def most_in(self, rows: slice) -> int:
        """Samples of each texel that one batch may have."""
        return self.most

    def strip(self, rows: slice, samples: int, seed: int) -> Floats:
        """Render one batch of the only row."""
        starts = range(0, self.size[1], self._texels)
        parts = [self._part(start, samples, seed + i) for i, start in enumerate(starts)]
        values = np.concatenate(parts, axis=2).transpose(0, 2, 1)[:, None]
        finite = np.isfinite(values)
        self.broken |= ~finite.all(axis=(0, 3))
        return np.where(finite, values, np.float32(0.0))

    def _part(self, start: int, samples: int, seed: int) -> Floats:
        """(lights, 3, texels) of some texels."""
        texels = min(self._texels, self.size[1] - start)
        paths = texels * samples
        numbers = FirstDimensions(samples, paths, random_numbers(seed ^ _SHIFT_SALT, texels))
        # As variables, not as parts of the compiled code: all batches share it.
        texel = dr.opaque(mi.UInt32, start) + dr.arange(mi.UInt32, paths) // dr.opaque(
            mi.UInt32, samples
        )
        found = irradiance_at(
            self._paths,
            self.planes,
            self._white,
            *self._points.chosen(texel, numbers.pixel.x),
            random_numbers(seed, paths),
            numbers,
        )
        sums = dr.block_sum(found, samples).numpy()
        return np.asarray(sums.reshape(-1, 3, texels) / np.float32(samples))


def irradiance_at(
    paths: Paths,
    lights: int,
    white: Callable[[Any], Any],
    points: Any,
    normals: Any,
    sampler: Any,
    numbers: FirstDimensions | None = None,
) -> Any:
    """The irradiance at points on surfaces, by one path from each.

    Args:
        paths: How they are followed: to their end, without bias, or as another method does it.
        lights: How many there are.
        white: Gives the white BSDF of a surface.
        points: P points on surfaces, relative to Mitsuba's origin.
        normals: P unit normals, to the side that is lit.
        sampler: Seeded for P paths.
        numbers: What the first surface draws by; None: the sampler's.

    Returns:
        (lights * 3 * P) lux; red, green and blue of a light lie side by side.
    """
    ray = mi.Ray3f(points + LIFT_M * normals, -normals)
    accumulator = PathAccumulator(dr.width(ray), lights)
    paths.follow(sampler, ray, accumulator, first=white, numbers=numbers)
    assert accumulator.lights is not None
    return accumulator.lights * dr.pi


class _Points:
    """Points of texels as arrays of the active variant."""

    def __init__(self, points: TexelPoints, origin: Array) -> None:
        local = (points.corners - origin).astype(np.float32)
        self._corners = mi.Float(local.ravel())
        self._normals = mi.Float(points.normals.astype(np.float32).ravel())
        self._first = mi.UInt32(points.first.astype(np.uint32))
        self._triangles = mi.UInt32(points.triangles.astype(np.uint32))
        self._weights = mi.Float(points.weights.ravel())

    def chosen(self, texel: Any, number: Any) -> tuple[Any, Any]:
        """One of the points of each texel, and its normal.

        Args:
            texel: Numbers of texels.
            number: In [0, 1): which of its points.
        """
        first = dr.gather(mi.UInt32, self._first, texel)
        count = dr.gather(mi.UInt32, self._first, texel + 1) - first
        point = first + dr.minimum(mi.UInt32(number * mi.Float(count)), count - 1)
        triangle = dr.gather(mi.UInt32, self._triangles, point)
        a, b, c = (dr.gather(mi.Point3f, self._corners, 3 * triangle + row) for row in range(3))
        second, third = dr.gather(mi.Point2f, self._weights, point)
        return a + second * (b - a) + third * (c - a), dr.gather(
            mi.Vector3f, self._normals, triangle
        )


def light_texels(
    paths: Paths,
    lights: int,
    white: Callable[[Any], Any],
    origin: Array,
    request: IrradianceRequest,
    progress: Callable[[float], None],
) -> Irradiance:
    """The irradiance of a request's texels, by light.

    Args:
        paths: How they are followed.
        lights: How many there are.
        white: Gives the white BSDF of a surface.
        origin: (3,) the point of the world that is Mitsuba's origin.
        request: What to find out.
        progress: Called with the finished fraction.
    """
    start = time.perf_counter()
    integrator = TexelIntegrator(paths, lights, white, request.points, origin)
    how = RenderRequest(None, (), 1, 1, samples=request.samples, seed=request.seed)
    halves = ProgressiveSampler(
        integrator, how, progress, lambda planes: np.asarray(planes.sum(axis=0)), "texels"
    ).whole()
    seconds, replaced = time.perf_counter() - start, int(integrator.broken.sum())
    return Irradiance(halves.mean[:, 0], halves.total, seconds, halves.estimate.robust, replaced)
