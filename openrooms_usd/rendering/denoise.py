"""Denoised radiance: a picture for people beside the raw one, by Intel's Open Image Denoise.

The network was trained on pictures and is biased: not a measurement. It sees the radiance with
base colour and shading normal as guides, both in the mean over whole pixels: where fine patterns
alias at the pixels' centres, it would bring their moire into pictures that have none. It runs on
the processor, where it gives the same bytes whatever the number of threads.
"""

import importlib
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Floats
from openrooms_usd.errors import InputError, MissingPackageError, RenderError
from openrooms_usd.rendering import contract
from openrooms_usd.rendering.contract import Image, View

DENOISED: Final = "denoised"
SOURCE: Final = "radiance"
# The filter's name of each guide.
_FILTER_NAMES: Final = dict(zip(contract.GUIDES, ("albedo", "normal"), strict=True))
# Pixels that are added around: at its edges the network makes a pattern of its own.
_BORDER_PIXELS: Final = 16


@dataclass(frozen=True)
class Denoiser:
    """Open Image Denoise, loaded.

    Attributes:
        package: The Python package that brings it.
        guides: What it is given beside the radiance.
    """

    package: ModuleType
    guides: tuple[str, ...] = contract.GUIDES

    def check(self, channels: tuple[str, ...]) -> None:
        """See that there will be something to denoise among channels that are asked for.

        Raises:
            InputError: The radiance is not asked for.
        """
        if SOURCE not in channels:
            raise InputError(
                f"only the channel {SOURCE!r} can be denoised, and it is not requested",
                place="channels",
                remedy=f"add {SOURCE}, or omit --denoise",
            )

    def complete(self, view: View) -> View:
        """The view with its denoised radiance."""
        began = time.perf_counter()
        pixels = self.denoise(view.images[SOURCE].pixels, view.guides)
        seconds = time.perf_counter() - began
        denoised = Image(pixels, view.images[SOURCE].samples, seconds, None)
        return replace(view, images={**view.images, DENOISED: denoised})

    def denoise(
        self, radiance: Floats, guides: Mapping[str, Floats], *, hdr: bool = True
    ) -> Floats:
        """Denoise a picture.

        Args:
            radiance: (H, W, 3) scene-linear; values that are not finite count as 0.
            guides: (H, W, 3) by channel; with hardly any noise.
            hdr: Whether it may have any brightness; otherwise it lies between 0 and 1.

        Returns:
            (H, W, 3) finite and not negative.

        Raises:
            RenderError: The denoiser failed, such as for lack of memory.
        """
        color: Floats = np.maximum(np.nan_to_num(radiance, posinf=0.0, neginf=0.0), 0.0)
        mean = float(color.mean(dtype=np.float64))
        if mean <= 0.0:
            return np.zeros_like(radiance)
        # By a power of two, which is exact: nights are then as bright to the network as days.
        scale = np.float32(2.0 ** round(math.log2(mean)) if hdr else 1.0)
        named = {_FILTER_NAMES[name]: _mirrored(pixels) for name, pixels in guides.items()}
        try:
            found: Any = self.package.denoise(_mirrored(color / scale), **named, hdr=hdr)
        except (RuntimeError, MemoryError) as error:
            raise RenderError(
                f"Open Image Denoise failed: {error or 'out of memory'}",
                remedy="omit --denoise, or render fewer pixels",
            ) from error
        inner = np.nan_to_num(found[_BORDER_PIXELS:-_BORDER_PIXELS, _BORDER_PIXELS:-_BORDER_PIXELS])
        return np.asarray(np.maximum(inner, 0.0) * scale, dtype=np.float32)

    def entry(self) -> dict[str, Any]:
        """What the manifest says about it."""
        return {
            "package": self.package.__name__,
            "version": _version(self.package.__name__),
            "filter": "RT, HDR, high quality",
            "source": SOURCE,
            "guides": list(self.guides),
            "guided_by": "means over all that a pixel sees, not by its centre as the channels are",
        }


def is_usable() -> bool:
    """Whether Open Image Denoise is installed and runs here."""
    try:
        _package()
    except MissingPackageError:
        return False
    return True


def load_denoiser() -> Denoiser:
    """Load Open Image Denoise.

    Raises:
        MissingPackageError: It is not installed, or cannot run here.
    """
    return Denoiser(_package())


def _package() -> ModuleType:
    try:
        return importlib.import_module("pyoidn")
    except (ImportError, OSError) as error:
        raise MissingPackageError(
            f"denoising needs the package 'pyoidn', which cannot be imported ({error})",
            remedy="pip install openrooms-usd[denoise], or omit --denoise",
        ) from error


def _mirrored(pixels: Floats) -> Floats:
    """The picture with a border that mirrors it."""
    around = ((_BORDER_PIXELS, _BORDER_PIXELS), (_BORDER_PIXELS, _BORDER_PIXELS), (0, 0))
    return np.pad(pixels, around, mode="symmetric").astype(np.float32)


def _version(package: str) -> str:
    from importlib.metadata import version

    return version(package)
