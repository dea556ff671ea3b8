"""Which render passes there are, and which channels of light each gives.

A render pass is one integrator with all channels (AOVs) that come of its pictures. Those that a
request needs share its time; each goes on until its own error is small enough where an error is
asked for. Strips of rows are finished one by one: what a pass keeps of the others are the pictures.
"""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.rendering import RenderRequest
from orusd_mitsuba.complete import channels as complete
from orusd_mitsuba.complete.integrator import CompleteIntegrator
from orusd_mitsuba.complete.smoothed import SmoothedPictures
from orusd_mitsuba.direct.control_variate import PLANES_PER_LIGHT, finish
from orusd_mitsuba.pictures import Changes, Images, Pick, Pictures, of_lights
from orusd_mitsuba.transport import hemispheres
from orusd_mitsuba.transport.integrator import Integrator
from orusd_mitsuba.transport.path_tracing import KINDS
from orusd_mitsuba.transport.sampling import ProgressiveSampler

Progress = Callable[[float], None]


@dataclass(frozen=True)
class RenderPass:
    """One integrator, and the channels that it gives.

    Attributes:
        name: For people.
        key: Sets its random numbers apart; passes that share them have noise in common, which
            then cancels in their differences.
        judged: The picture whose error decides when it is enough.
        picks: By channel, what makes its picture of an integrator's planes; of a channel of every
            light, given the light's number.
        fewer: How many samples of a pixel are one of this pass: hemispheres have many cells.
    """

    name: str
    key: str
    judged: Pick
    picks: dict[str, Callable[[Array, int], Array]]
    fewer: int = 1

    def gives(self, channels: Iterable[str]) -> tuple[str, ...]:
        """Those of the channels that it gives."""
        return tuple(name for name in channels if name in self.picks)


def _kinds(*wanted: str) -> Callable[[Array, int], Array]:
    rows = [KINDS.index(kind) for kind in wanted]
    return lambda planes, light: np.asarray(planes[rows].sum(axis=0))


def _of_light() -> Callable[[Array, int], Array]:
    return lambda planes, light: np.asarray(planes[len(KINDS) + light])


def _whole(planes: Array) -> Array:
    return np.asarray(planes[: len(KINDS)].sum(axis=0))


RADIANCE: Final = RenderPass(
    "radiance",
    "",
    _whole,
    {
        "radiance": lambda planes, light: _whole(planes),
        "emission": _kinds("emission"),
        "direct": _kinds("direct"),
        "indirect": _kinds("indirect"),
        "radiance_i": _of_light(),
    },
)


def _straight(name: str) -> Callable[[Array, int], Array]:
    def pick(planes: Array, light: int) -> Array:
        return np.asarray(finish(planes[light :: len(planes) // PLANES_PER_LIGHT])[name][0])

    return pick


def _row(number: int) -> Callable[[Array, int], Array]:
    return lambda planes, light: np.asarray(planes[number])


# What each light sends straight.
DIRECT: Final = RenderPass(
    "direct light",
    "direct",
    lambda planes: np.asarray(planes[: len(planes) // PLANES_PER_LIGHT].sum(axis=0)),
    {name: _straight(name) for name in ("direct_i", "unoccluded_i", "visibility_i")},
)
# Everything at the pixels, from the same samples.
COMPLETE: Final = RenderPass(
    "light", "complete", lambda planes: complete.PICKS["radiance"](planes, 0), complete.PICKS
)
# What arrives from everywhere.
ENVIRONMENT: Final = RenderPass(
    "environment",
    "environment",
    lambda planes: np.asarray(planes[hemispheres.PLANES.index("environment")]),
    {name: _row(row) for row, name in enumerate(hemispheres.PLANES)},
    fewer=16,
)


def passes_for(channels: Iterable[str]) -> list[tuple[RenderPass, tuple[str, ...]]]:
    """The render passes that give channels of light, each with its share of them.

    Where one that does less is enough, it is taken; all others come from the same samples.
    """
    wanted = tuple(channels)
    at_pixels = COMPLETE.gives(wanted)
    chosen = []
    if at_pixels:
        enough = (one for one in (RADIANCE, DIRECT) if one.gives(wanted) == at_pixels)
        chosen.append(next(enough, COMPLETE))
    if ENVIRONMENT.gives(wanted):
        chosen.append(ENVIRONMENT)
    return [(one, one.gives(wanted)) for one in chosen]


def run_pass(
    render_pass: RenderPass,
    integrator: Integrator,
    request: RenderRequest,
    channels: Sequence[str],
    lights: int,
    progress: Progress,
) -> tuple[Images, Changes, ProgressiveSampler]:
    """Render one pass until the request is met.

    With guides, indirect light is averaged over neighbours.

    Args:
        render_pass: What it is.
        integrator: Renders its batches.
        request: Says when it is enough.
        channels: Those that it shall give.
        lights: How many there are.
        progress: Called with the finished fraction.

    Returns:
        The images by name, what smoothing has changed of these, and what rendered them.
    """
    start = time.perf_counter()
    if request.samples is not None:
        request = replace(request, samples=max(1, request.samples // render_pass.fewer))
    sampler = ProgressiveSampler(integrator, request, progress, render_pass.judged, render_pass.key)
    picks = of_lights({name: render_pass.picks[name] for name in channels}, lights)
    pictures = Pictures(picks, integrator.size)
    if isinstance(integrator, CompleteIntegrator) and integrator.guided:
        pictures = SmoothedPictures(picks, integrator.size, integrator.lights)
    sampler.run(pictures.finish)
    samples = sampler.samples[0], sampler.samples[1]
    if isinstance(pictures, SmoothedPictures):
        pictures.smooth(samples)
    replaced, seconds = int(integrator.broken.sum()), time.perf_counter() - start
    images = pictures.images(samples, seconds, replaced, keep=request.halves)
    return images, pictures.changes, sampler
