"""Which channels of a view are rendered, which are made of these, and which are written."""

from dataclasses import dataclass, replace
from functools import cached_property

from openrooms_usd.channels import FLOWS, each
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering.contract import Renderer, View
from openrooms_usd.rendering.denoise import DENOISED, Denoiser, load_denoiser
from openrooms_usd.rendering.denoised_light import with_denoised_light
from openrooms_usd.rendering.friction import FRICTION, FrictionMap
from openrooms_usd.rendering.given import available
from openrooms_usd.rendering.plan import choose_channels
from openrooms_usd.rendering.shading import Shading


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
