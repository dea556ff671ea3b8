"""What one exact ray through each pixel's centre tells: geometry, materials, labels, and flow."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import numbered
from openrooms_usd.rendering.contract import GUIDES, Image, RenderRequest, View
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import first_hits
from openrooms_usd.rendering.scene.flow import optical_flow
from openrooms_usd.rendering.scene.ground_truth import GroundTruth
from openrooms_usd.rendering.scene.light_masks import light_masks
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.rendering.scene.sources import Source
from openrooms_usd.usd.cameras import PinholeCamera

# Guides are looked up at so many by so many places of a pixel.
_GUIDED_PLACES: Final = 2


def exact_images(
    scene: Scene,
    tracer: RayTracer,
    sources: Sequence[Source],
    camera: PinholeCamera,
    size: tuple[int, int],
    channels: Sequence[str],
) -> dict[str, Image]:
    """Exact channels of a camera; the ray that all share is in the time of each.

    Args:
        scene: What is seen.
        tracer: Finds the triangles.
        sources: The lights, by their numbers.
        camera: For the size.
        size: Width and height, pixels.
        channels: Names from `openrooms_usd.rendering.given.EXACT`.

    Returns:
        By channel; of ``mask_i`` one for each light.
    """
    if not channels:
        return {}
    start = time.perf_counter()
    hits = first_hits(scene, tracer, camera, *size)
    truth = GroundTruth(scene, camera, hits)
    shared = time.perf_counter() - start
    images: dict[str, Image] = {}
    for name in channels:
        start = time.perf_counter()
        if name == "mask_i":
            masks = light_masks(scene, sources, camera, hits)
            made = {numbered(name, light): mask for light, mask in enumerate(masks)}
        else:
            made = {name: truth.channel(name)}
        seconds = shared + time.perf_counter() - start
        for single, pixels in made.items():
            images[single] = Image(pixels, 1, seconds, 0.0, robust_error=0.0)
    return images


def flow_images(
    scene: Scene,
    tracer: RayTracer,
    camera: PinholeCamera,
    after: PinholeCamera,
    size: tuple[int, int],
) -> dict[str, Image]:
    """Where what a frame of a path sees is in the next frame (`openrooms_usd.channels.FLOWS`).

    Args:
        scene: What is seen.
        tracer: Finds the triangles.
        camera: Of the frame, for the size.
        after: Of the next frame, likewise.
        size: Width and height, pixels.
    """
    start = time.perf_counter()
    made = optical_flow(scene, tracer, camera, after, size)
    seconds = time.perf_counter() - start
    return {name: Image(pixels, 1, seconds, 0.0, robust_error=0.0) for name, pixels in made.items()}


def fine_guides(
    picture: Callable[[PinholeCamera, RenderRequest], View],
    camera: PinholeCamera,
    request: RenderRequest,
) -> dict[str, NDArray[np.float32]]:
    """What a denoiser is guided by, where the renderer does not give it: means over whole pixels.

    Args:
        picture: Renders channels of a camera.
        camera: For the request's size.
        request: Its size.

    Returns:
        (height, width, 3) by channel of `openrooms_usd.rendering.contract.GUIDES`.
    """
    n, height, width = _GUIDED_PLACES, request.height, request.width
    fine = replace(camera, K=np.diag([n, n, 1.0]) @ camera.K)
    asked = replace(request, channels=GUIDES, width=n * width, height=n * height, guides=False)
    images = picture(fine, asked).images
    return {
        name: images[name].pixels.reshape(height, n, width, n, -1).mean(axis=(1, 3))
        for name in GUIDES
    }
