"""Light probes: incident radiance at points in free space, as panoramas."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.geometry.hemisphere import PANORAMA, HemisphereGrid
from openrooms_usd.rendering import Image, RenderRequest
from openrooms_usd.rendering.probes import ProbeRequest
from orusd_mitsuba.transport.cells import Points
from orusd_mitsuba.transport.incident import IncidentRadiance
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.sampling import ProgressiveSampler

# Paths that one batch may follow.
_PATHS_A_BATCH: Final = 1 << 21


class ProbeIntegrator:
    """Renders batches of samples of the panorama about a point.

    Args:
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        position: (3,) metres, relative to Mitsuba's origin.
        size: Height and width.
        depth: At most this many segments of a path from a light to the point.

    Attributes:
        planes: 1.
        size: Height and width.
        most: Samples of each pixel that one batch may have at most.
        broken: (height, width) bool, pixels in which a batch gave no number.
    """

    def __init__(
        self, built: Any, index: LightIndex, position: Array, size: tuple[int, int], depth: int
    ) -> None:
        cells = HemisphereGrid(*size, np.pi)
        point = Points(position[None], PANORAMA[None], np.zeros((1, 3)))
        self._incident = IncidentRadiance(built, index, cells, point, depth)
        self.planes, self.size = 1, size
        self.most = max(1, _PATHS_A_BATCH // cells.count)
        self.broken = np.zeros(size, dtype=bool)

    def __call__(self, samples: int, seed: int) -> Floats:
        """Render one batch; equal seeds give equal bits.

        Returns:
            (1, height, width, 3).
        """
        return self.strip(slice(0, self.size[0]), samples, seed)

    def strips(self, samples: int) -> list[slice]:
        """All rows: panoramas are rendered whole."""
        return [slice(0, self.size[0])]

    def most_in(self, rows: slice) -> int:
        """Samples of each pixel that one batch may have."""
        return self.most

    def strip(self, rows: slice, samples: int, seed: int) -> Floats:
        """Render one batch of all rows."""
        pixels = self._incident(samples, seed)[1].reshape(1, *self.size, 3)
        finite = np.isfinite(pixels)
        self.broken |= ~finite.all(axis=(0, 3))
        return np.where(finite, pixels, np.float32(0.0))


def render_probes(
    built: Any,
    index: LightIndex,
    origin: Array,
    request: ProbeRequest,
    progress: Callable[[float], None],
) -> tuple[Image, ...]:
    """The panoramas of a request, in its order.

    Args:
        built: The Mitsuba scene of a vectorized variant.
        index: Its lights.
        origin: (3,) the point of the world that is Mitsuba's origin.
        request: What to render.
        progress: Called with the finished fraction.
    """
    size, count = (request.height, request.width), len(request.positions)
    how = RenderRequest(
        None, (), request.width, request.height, samples=request.samples, seed=request.seed
    )
    images = []
    for number, position in enumerate(request.positions):
        start = time.perf_counter()
        integrator = ProbeIntegrator(
            built, index, np.array(position) - origin, size, request.bounces + 1
        )
        part = partial(_part, progress, number, count)
        sampler = ProgressiveSampler(
            integrator, how, part, lambda planes: np.asarray(planes[0]), f"probe {position}"
        )
        halves = sampler.whole()
        seconds, replaced = time.perf_counter() - start, int(integrator.broken.sum())
        found = halves.estimate
        made = Image(halves.mean[0], halves.total, seconds, found.relative_mse, replaced)
        images.append(replace(made, robust_error=found.robust))
    return tuple(images)


def _part(progress: Callable[[float], None], number: int, count: int, done: float) -> None:
    """One panorama's progress as that of all."""
    progress((number + done) / count)
