"""The pictures: 8-bit colours under one exposure, and depth in millimetres.

A radiance field takes the same point for the same colour in every view, so all views have one
exposure, and the curve works on each pixel by itself.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import atomic, imagefile
from openrooms_usd.arrays import Bytes
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.rendering import color
from openrooms_usd.rendering.exr import Pixels
from openrooms_usd.rendering.reading import RenderedScene, RenderedView

IMAGES: Final = "images"
DEPTHS: Final = "depths"
# nerfstudio's default; for instant-ngp it is in ``transforms.json``.
DEPTH_STEP_M: Final = 1e-3
_MOST_STEPS: Final = 2**16 - 1


def image_name(view: str) -> str:
    """The file of a view, the same in both folders."""
    return f"{view}.png"


def light_of(view: RenderedView) -> Pixels | None:
    """(height, width, 3) what a view's image is made of, scene-linear; None without light."""
    return view.pixels.get("denoised", view.pixels.get("radiance"))


@dataclass(frozen=True)
class Survey:
    """What all views of a render have.

    Attributes:
        exposure: The factor for all of them: the geometric mean of theirs; None without light.
        depths: Whether they have depth.
    """

    exposure: float | None
    depths: bool


def survey(render: RenderedScene) -> Survey:
    """Look through the views of a render.

    Raises:
        InputError: A file is missing or damaged.
    """
    factors: list[float] = []
    depths = 0
    for view in render.each():
        depths += "depth" in view.pixels
        if (light := light_of(view)) is not None:
            factors.append(view.entry.exposure or color.fitted_exposure(light))
    count = len(render.views)
    exposure = math.exp(math.fsum(map(math.log, factors)) / count)
    return Survey(exposure if len(factors) == count else None, depths == count)


def write_image(folder: Path, view: RenderedView, exposure: float) -> Bytes:
    """Write a view's image.

    Args:
        folder: The dataset.
        view: A view with light.
        exposure: What light is multiplied by.

    Returns:
        (height, width, 3) the pixels.

    Raises:
        OutputError: The file cannot be written.
    """
    light = light_of(view)
    assert light is not None
    known = np.nan_to_num(light, nan=0.0, posinf=0.0, neginf=0.0)
    pixels = color.quantize(srgb_from_linear(color.film(known * np.float32(exposure))))
    with atomic.replacing(folder / IMAGES / image_name(view.name)) as beside:
        imagefile.write_png(beside, pixels)
    return pixels


def write_depth(folder: Path, view: RenderedView) -> int:
    """Write a view's planar depth in steps of 1 mm; 0 where nothing is, or what is too far.

    Returns:
        How many pixels lie too far away for 16 bits.

    Raises:
        OutputError: The file cannot be written.
    """
    steps = np.rint(view.pixels["depth"].astype(np.float64) / DEPTH_STEP_M)
    far = ~(steps <= _MOST_STEPS)
    pixels = np.where(far, 0, steps).astype(np.uint16)
    with atomic.replacing(folder / DEPTHS / image_name(view.name)) as beside:
        imagefile.write(beside, pixels, "uint16", {"png:compressionLevel": 4})
    return int(far.sum())
