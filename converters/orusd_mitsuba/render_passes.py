"""Which render passes there are, and which channels of light each gives.

A render pass is one integrator with all channels (AOVs) that come of its pictures. Those that a
request needs share its time; each goes on until its own error is small enough where an error is
asked for. Strips of rows are finished one by one: what a pass keeps of the others are the pictures.
"""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.channels import CHANNELS, numbered
from openrooms_usd.render import Image, RenderRequest
from openrooms_usd.render.estimates import ErrorEstimate
from openrooms_usd.render.halves import HalvedPicture
from openrooms_usd.render.scene.pictures import Array
from orusd_mitsuba.complete import channels as complete
from orusd_mitsuba.direct.control_variate import PLANES_PER_LIGHT, finish
from orusd_mitsuba.transport import hemispheres
from orusd_mitsuba.transport.integrator import Integrator
from orusd_mitsuba.transport.path_tracing import KINDS
from orusd_mitsuba.transport.sampling import Halves, Pick, ProgressiveSampler

Progress = Callable[[float], None]
Images = dict[str, Image]


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
) -> tuple[Images, ProgressiveSampler]:
    """Render one pass until the request is met.

    Args:
        render_pass: What it is.
        integrator: Renders its batches.
        request: Says when it is enough.
        channels: Those that it shall give.
        lights: How many there are.
        progress: Called with the finished fraction.

    Returns:
        The images by name, and what rendered them.
    """
    start = time.perf_counter()
    if request.samples is not None:
        request = replace(request, samples=max(1, request.samples // render_pass.fewer))
    sampler = ProgressiveSampler(integrator, request, progress, render_pass.judged, render_pass.key)
    pictures = _Pictures(render_pass, channels, lights, integrator.size)
    sampler.run(pictures.finish)
    replaced, seconds = int(integrator.broken.sum()), time.perf_counter() - start
    samples = sampler.samples[0], sampler.samples[1]
    return pictures.images(samples, seconds, replaced, keep=request.halves), sampler


def _picked(pick: Callable[[Array, int], Array], light: int, planes: Array) -> Array:
    return pick(planes, light)


class _Pictures:
    """The channels of one pass, which fill up strip by strip.

    Args:
        render_pass: What gives them.
        channels: Those that it shall give.
        lights: How many there are.
        size: Height and width.
    """

    def __init__(
        self, render_pass: RenderPass, channels: Sequence[str], lights: int, size: tuple[int, int]
    ) -> None:
        self._picks: dict[str, Callable[[Array], Array]] = {}
        for name in channels:
            of_light, pick = CHANNELS[name].scope == "light", render_pass.picks[name]
            for light in range(lights) if of_light else (0,):
                single = numbered(name, light) if of_light else name
                self._picks[single] = partial(_picked, pick, light)
        self._kept = {
            name: HalvedPicture.blank(np.zeros((*size, 3), np.float32)) for name in self._picks
        }

    def finish(self, rows: slice, halves: Halves) -> None:
        """Fill in a strip."""
        mean, each = halves.mean.astype(np.float64), halves.each
        for name, pick in self._picks.items():
            self._kept[name].pixels[rows] = pick(mean)
            if each:
                self._kept[name].fill(rows, pick(each[0]), pick(each[1]))

    def images(
        self, samples: tuple[int, int], seconds: float, replaced: int, *, keep: bool
    ) -> Images:
        """The finished ones.

        Args:
            samples: Of a pixel, in each half.
            seconds: What they took.
            replaced: Pixels in which there was no number.
            keep: Whether images shall have their halves.
        """
        images: Images = {}
        for name in self._picks:
            kept = self._kept.pop(name)
            halves = kept.of(samples) if min(samples) else None
            told = halves.estimate if halves else ErrorEstimate(None, None)
            images[name] = Image(
                kept.pixels, sum(samples), seconds, told.relative_mse, replaced,
                halves if keep else None, robust_error=told.robust,
            )  # fmt: skip
        return images
