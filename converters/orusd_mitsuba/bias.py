"""The bias of a picture, measured at few of its pixels by paths that are followed to their end.

Their random numbers are others than the picture's; which pixels, and how many, follows from the
request alone, so that equal requests have equal manifests.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import definition
from openrooms_usd.render import Image, RenderRequest, bias
from openrooms_usd.render.bias import SparsePixels
from orusd_mitsuba.render_passes import RenderPass, run_pass
from orusd_mitsuba.transport.integrator import SparseIntegrator
from orusd_mitsuba.transport.sampling import batch_seed

# Of the view's samples; one of the reference takes some times longer.
_SAMPLES_SHARE: Final = 1 / 32
# In each half. More pixels tell more than more samples.
_SAMPLES_A_HALF: Final = 2
_LEAST_PIXELS: Final = 256
_LEAST_HEMISPHERES: Final = 16
_MOST_PIXELS: Final = 1 << 14
# Of their own estimator, which needs no paths: ratios and clamped numbers are not compared.
_WITHOUT_PATHS: Final = ("direct_i", "unoccluded_i", "visibility_i")


def measurable(channels: Sequence[str]) -> tuple[str, ...]:
    """Those of the channels whose bias can be measured."""
    return tuple(name for name in channels if name not in _WITHOUT_PATHS)


def with_bias(
    images: Mapping[str, Image],
    render_pass: RenderPass,
    reference: SparseIntegrator,
    request: RenderRequest,
    channels: Sequence[str],
    lights: int,
) -> dict[str, Image]:
    """The images of a pass with the bias that they have.

    Args:
        images: By name, with their halves.
        render_pass: What gave them.
        reference: Renders the same pictures without bias.
        request: What was asked for.
        channels: Those to measure.
        lights: How many there are.

    Returns:
        All images; those of other channels as they are.
    """
    first = images[next(name for name in images if definition(name).name in channels)]
    pixels, samples = _chosen(first, render_pass, request)
    asked = replace(
        request, samples=samples * render_pass.fewer, error=None, seconds=None, halves=True
    )
    apart = replace(render_pass, key=f"{render_pass.key} bias")
    sparse = reference.sparse(pixels.numbers)
    truth = run_pass(apart, sparse, asked, channels, lights, lambda done: None)[0]
    tile = first.pixels.shape[0] // pixels.height, first.pixels.shape[1] // pixels.width
    row = SparsePixels(len(pixels.numbers), 1, np.arange(len(pixels.numbers), dtype=np.uint32),
                       pixels.weights)  # fmt: skip
    measured = {
        name: replace(
            images[name],
            bias=bias.measure(
                _halves(images[name], pixels, tile), _halves(found, row, tile), pixels
            ),
        )
        for name, found in truth.items()
    }
    return {**images, **measured}


def _chosen(
    image: Image, render_pass: RenderPass, request: RenderRequest
) -> tuple[SparsePixels, int]:
    """The pixels to render again, hemispheres of a grid, and how many samples each takes."""
    is_grid = any(definition(name).scope == "grid" for name in render_pass.picks)
    width, height = request.grid if is_grid else (request.width, request.height)
    least = _LEAST_HEMISPHERES if is_grid else _LEAST_PIXELS
    each = 2 * _SAMPLES_A_HALF
    budget = _SAMPLES_SHARE * width * height * image.samples
    count = int(np.clip(budget / each, least, _MOST_PIXELS))
    seed = batch_seed(request.seed, request.camera, "bias")
    pixels = SparsePixels.draw(width, height, count, np.random.default_rng(seed))
    return pixels, each * max(1, round(budget / (each * len(pixels.numbers))))


def _halves(image: Image, pixels: SparsePixels, tile: tuple[int, int]) -> NDArray[Any]:
    """(2, N, 3) halves of a picture at pixels, or (1, N, 3) where it has none; means of tiles."""
    parts = (image.halves.a, image.halves.b) if image.halves else (image.pixels,)
    rows, columns = np.divmod(pixels.numbers.astype(np.int64), pixels.width)
    shape = pixels.height, tile[0], pixels.width, tile[1], -1
    return np.stack([part.reshape(shape)[rows, :, columns].mean(axis=(1, 2)) for part in parts])
