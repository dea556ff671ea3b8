"""Denoised versions of the channels of light beside the raw ones, each with what it is off by.

The network is made for pictures of surfaces. What is reflected is denoised with base colour and
normal as guides; what is received has no texture, so with the normal alone (beside a white albedo,
which the network asks for); a visibility is a number between 0 and 1. Masks have no noise; a tile
of a hemisphere is no picture of a surface, and a difference may be negative: these stay raw.

Every channel is denoised for itself: denoised lights no longer sum exactly to the denoised whole.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import definition
from openrooms_usd.rendering.contract import DenoisedImage, Image, View
from openrooms_usd.rendering.denoise import Denoiser
from openrooms_usd.rendering.halves import KeptHalves

Denoise = bool | Literal["all"]
"""What is denoised: nothing, the radiance, or all channels of light that can bear it."""

REFLECTED: Final = ("direct", "indirect", "diffuse", "specular", "radiance_i")
RECEIVED: Final = (
    "irradiance",
    "irradiance_direct",
    "irradiance_indirect",
    "irradiance_i",
    "direct_i",
    "unoccluded_i",
    "irradiance_unoccluded_i",
)
RATIOS: Final = ("visibility_i",)
# Blocks in which the mean of a denoised picture is compared with the raw one.
_BLOCK_PIXELS: Final = 16
_BEYOND_STANDARD_ERRORS: Final = 2.0


@dataclass(frozen=True)
class EnergyChange:
    """By how much denoising changes the mean of a picture.

    Attributes:
        bias: The mean of the denoised picture over that of the raw one, less 1; None where that
            is black.
        standard_error: Of the raw mean, relative; None without an estimate.
        blocks_beyond: The part of blocks of 16x16 pixels whose mean is more than two standard
            errors from the raw one: 0.05 by noise alone; None without an estimate.
    """

    bias: float | None
    standard_error: float | None
    blocks_beyond: float | None


def with_denoised_light(view: View, denoiser: Denoiser) -> View:
    """The view with denoised versions of the channels of light that can bear it.

    Args:
        view: With the denoiser's guides, and halves.
        denoiser: What is loaded.
    """
    guides = view.guides
    found = {
        name: _denoised(name, image, guides, denoiser)
        for name, image in view.images.items()
        if definition(name).name in (*REFLECTED, *RECEIVED, *RATIOS) and image.pixels.min() >= 0.0
    }
    return replace(view, denoised=found)


def _denoised(
    name: str, image: Image, guides: Mapping[str, NDArray[np.float32]], denoiser: Denoiser
) -> DenoisedImage:
    kind = definition(name).name
    if kind not in REFLECTED and "base_color" in guides:
        guides = {**guides, "base_color": np.ones_like(guides["base_color"])}
    is_ratio = kind in RATIOS
    pixels = denoiser.denoise(image.pixels, guides, hdr=not is_ratio)
    return DenoisedImage(pixels, asdict(energy_change(image.pixels, pixels, image.halves)))


def energy_change(
    raw: NDArray[np.float32], denoised: NDArray[np.float32], halves: KeptHalves | None
) -> EnergyChange:
    """By how much the mean of a picture has changed, over all of it and in blocks.

    Args:
        raw: (height, width, 3).
        denoised: The same.
        halves: Of the raw picture, if there are any.
    """
    mean = float(raw.mean(dtype=np.float64))
    if mean <= 0.0:
        return EnergyChange(None, None, None)
    change = denoised.astype(np.float64) - raw
    bias = float(change.mean()) / mean
    if halves is None:
        return EnergyChange(bias, None, None)
    variance = halves.deviation[:].astype(np.float64) ** 2
    # Colours of a pixel go together: their errors add up.
    spread = np.sqrt(variance).mean(axis=-1) ** 2
    blocks, noise = _summed(change.mean(axis=-1)), _summed(spread)
    beyond = np.abs(blocks) > _BEYOND_STANDARD_ERRORS * np.sqrt(noise)
    return EnergyChange(
        bias,
        float(np.sqrt(spread.sum())) / (raw.shape[0] * raw.shape[1] * mean),
        float(beyond.mean()),
    )


def _summed(plane: NDArray[np.float64]) -> NDArray[Any]:
    """Sums over blocks; those at the right and at the bottom may be smaller."""
    rows, columns = (range(0, side, _BLOCK_PIXELS) for side in plane.shape)
    return np.add.reduceat(np.add.reduceat(plane, [*rows], axis=0), [*columns], axis=1)
