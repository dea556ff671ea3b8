"""The bias of a picture, measured at few of its pixels by paths that are followed to their end.

The method renders these pixels again, too, with the same random numbers as the reference: as long
as both do the same, straight light and the first scattering, they do it with the same noise, and
their difference has none. The random numbers are others than the picture's. Which pixels, and how
many, follows from the request alone, so that equal requests have equal manifests.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Floats
from openrooms_usd.channels import definition
from openrooms_usd.rendering import Image, RenderRequest
from openrooms_usd.rendering.bias import Bias, SparsePixels, measure
from orusd_mitsuba.pictures import BLOCK_PIXELS, Changes
from orusd_mitsuba.render_passes import RenderPass, run_pass
from orusd_mitsuba.transport.integrator import SparseIntegrator
from orusd_mitsuba.transport.sampling import batch_seed

# Of the view's samples; one of the reference takes some times longer.
_SAMPLES_SHARE: Final = 1 / 64
_LEAST_PIXELS: Final = 512
_LEAST_HEMISPHERES: Final = 16
_MOST_PIXELS: Final = 1 << 16
# Of their own estimator, which needs no paths: ratios and clamped numbers are not compared.
_WITHOUT_PATHS: Final = ("direct_i", "unoccluded_i", "visibility_i", "traced")


def measurable(channels: Sequence[str]) -> tuple[str, ...]:
    """Those of the channels whose bias can be measured."""
    return tuple(name for name in channels if name not in _WITHOUT_PATHS)


def with_bias(
    images: Mapping[str, Image],
    changes: Changes,
    render_pass: RenderPass,
    biased: SparseIntegrator,
    reference: SparseIntegrator,
    request: RenderRequest,
    channels: Sequence[str],
    lights: int,
) -> dict[str, Image]:
    """The images of a pass with the bias that they have.

    Args:
        images: By name.
        changes: What was done to them that is not done to sparse pixels.
        render_pass: What gave them.
        biased: What rendered them.
        reference: Renders the same without bias.
        request: What was asked for.
        channels: Those to measure.
        lights: How many there are.

    Returns:
        All images; those of other channels as they are.
    """
    first = images[next(name for name in images if definition(name).name in channels)]
    pixels, samples = _chosen(first, render_pass, request)
    asked = replace(
        request, samples=samples * render_pass.fewer, error=None, seconds=None, halves=False
    )
    apart = replace(render_pass, key=f"{render_pass.key} bias")
    found, truth = (
        run_pass(apart, which.sparse(pixels.numbers), asked, channels, lights, lambda done: None)[0]
        for which in (biased, reference)
    )
    return {
        name: replace(
            image, bias=_measured(image, found[name], truth[name], pixels, changes.get(name))
        )
        if name in truth
        else image
        for name, image in images.items()
    }


def _measured(
    image: Image, found: Image, truth: Image, pixels: SparsePixels, change: Floats | None
) -> Bias | None:
    # A pixel may be a tile of the picture, a hemisphere: then its mean counts.
    tile = image.pixels.shape[0] // pixels.height, image.pixels.shape[1] // pixels.width
    rows, columns = np.divmod(pixels.numbers.astype(np.int64), pixels.width)
    cut = image.pixels.reshape(pixels.height, tile[0], pixels.width, tile[1], -1)
    brightness = cut[rows, :, columns].mean(axis=(1, 2, 3), dtype=np.float64)
    a, b = (
        row.pixels.reshape(tile[0], -1, tile[1], 3).mean(axis=(0, 2), dtype=np.float64)
        for row in (found, truth)
    )
    if change is not None:
        # Each pixel stands for its surroundings: there the change is known, with little noise.
        a = a + change[rows // BLOCK_PIXELS, columns // BLOCK_PIXELS]
    return measure(a, b, pixels, brightness, paths=tile[0] * tile[1] * truth.samples)


def _chosen(
    image: Image, render_pass: RenderPass, request: RenderRequest
) -> tuple[SparsePixels, int]:
    """The pixels to render again, hemispheres of a grid, and how many samples each takes.

    More pixels tell more than more samples.
    """
    is_grid = any(definition(name).scope == "grid" for name in render_pass.picks)
    width, height = request.grid if is_grid else (request.width, request.height)
    least = _LEAST_HEMISPHERES if is_grid else _LEAST_PIXELS
    budget = _SAMPLES_SHARE * width * height * image.samples
    seed = batch_seed(request.seed, request.camera, "bias")
    pixels = SparsePixels.draw(
        width, height, int(np.clip(budget, least, _MOST_PIXELS)), np.random.default_rng(seed)
    )
    return pixels, max(1, round(budget / len(pixels.numbers)))
