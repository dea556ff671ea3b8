"""Which channels of a view are rendered, which are made of these, and which are written."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.channels import FLOWS, definition, each
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering.contract import DenoisedImage, Image, Renderer, View
from openrooms_usd.rendering.denoise import DENOISED, Denoiser, load_denoiser
from openrooms_usd.rendering.friction import FRICTION, FrictionMap
from openrooms_usd.rendering.given import available
from openrooms_usd.rendering.halves import KeptHalves
from openrooms_usd.rendering.plan import choose_channels
from openrooms_usd.rendering.shading import Shading

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


@dataclass(frozen=True, eq=False)
class ChannelPlan:
    """The way from what a renderer gives to what a view has.

    Attributes:
        asked: The channels that are asked for, in the order of the table.
        shading: What makes channels of shading of others.
        settings: What else is asked for.
        denoiser: What takes noise away, where that is asked for.
        flow: Whether views are frames of a path, which have the optical flow to the next one.
    """

    asked: tuple[str, ...]
    shading: Shading
    settings: RenderSettings
    denoiser: Denoiser | None = None
    flow: bool = False

    @classmethod
    def of(
        cls, settings: RenderSettings, renderer: Renderer, *, flow: bool = False
    ) -> "ChannelPlan":
        """The plan of a render.

        Raises:
            InputError: A channel is unknown, or neither the renderer gives it nor the core.
            MissingPackageError: The denoiser is asked for and not installed.
        """
        asked = choose_channels(settings.channels, available(renderer.channels))
        wanted = settings.denoise or settings.denoise_light
        denoiser = load_denoiser() if wanted else None
        if denoiser:
            denoiser.check(asked)
        return cls(asked, Shading(renderer.channels), settings, denoiser, flow)

    @property
    def written(self) -> tuple[str, ...]:
        """The channels that views have in the end."""
        return (*self.asked, *(FLOWS if self.flow else ()), *((DENOISED,) if self.denoiser else ()))

    @property
    def rendered(self) -> tuple[str, ...]:
        """The channels that the renderer and the core are asked for."""
        return self.shading.needs(self._shaded) if self._makes_shading else self._shaded

    @property
    def halves(self) -> bool:
        """Whether images need two halves: errors of what is made of others need it made twice."""
        settings = self.settings
        return settings.error_maps or self._makes_shading or settings.denoise_light

    def complete(self, view: View, lights: int, friction: FrictionMap | None) -> View:
        """A view with all that is made of what was rendered.

        Args:
            view: With the channels `rendered`.
            lights: How many there are.
            friction: What tells friction of materials, where that is asked for.
        """
        if self._makes_shading:
            view = self.shading.complete(view, each(self._shaded, lights))
        if friction:
            view = friction.complete(view, each(self.asked, lights))
        if self.denoiser:
            light = self.settings.denoise_light
            clean = with_denoised_light(view, self.denoiser).denoised if light else {}
            view = replace(self.denoiser.complete(view), denoised=clean)
        return view if self.settings.error_maps else _without_halves(view)

    @cached_property
    def _shaded(self) -> tuple[str, ...]:
        """The channels once shading is made: all that is asked for, or that friction needs."""
        return FrictionMap.needs(self.asked) if FRICTION in self.asked else self.asked

    @cached_property
    def _makes_shading(self) -> bool:
        return self.shading.makes(self.asked)


def _without_halves(view: View) -> View:
    images = {name: replace(image, halves=None) for name, image in view.images.items()}
    return replace(view, images=images)


# The network is made for pictures of surfaces. Reflected light is denoised with base colour and
# normal as guides. Received light has no texture, so its only guide is the normal, beside the white
# albedo that the network needs. A visibility is a number between 0 and 1. Masks have no noise, a
# tile of a hemisphere does not show a surface, and a difference may be negative: these stay raw.
# Every channel is denoised for itself: denoised lights no longer sum exactly to the denoised
# whole.
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
    name: str, image: Image, guides: Mapping[str, Floats], denoiser: Denoiser
) -> DenoisedImage:
    kind = definition(name).name
    if kind not in REFLECTED and "base_color" in guides:
        guides = {**guides, "base_color": np.ones_like(guides["base_color"])}
    is_ratio = kind in RATIOS
    pixels = denoiser.denoise(image.pixels, guides, hdr=not is_ratio)
    return DenoisedImage(pixels, asdict(energy_change(image.pixels, pixels, image.halves)))


def energy_change(raw: Floats, denoised: Floats, halves: KeptHalves | None) -> EnergyChange:
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


def _summed(plane: Array) -> NDArray[Any]:
    """Sums over blocks; those at the right and at the bottom may be smaller."""
    rows, columns = (range(0, side, _BLOCK_PIXELS) for side in plane.shape)
    return np.add.reduceat(np.add.reduceat(plane, [*rows], axis=0), [*columns], axis=1)
