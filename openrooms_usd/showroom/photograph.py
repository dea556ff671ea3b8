"""One picture of one camera, as sheets show it."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from openrooms_usd.arrays import Bytes
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering.denoise import DENOISED, SOURCE
from openrooms_usd.rendering.previews import preview

if TYPE_CHECKING:
    from openrooms_usd.rendering.context import RenderContext

_BOUNCES: Final = 4


def photograph_settings(
    renderer: str,
    options: Mapping[str, str],
    *,
    denoise: bool,
    samples: int,
    size: int,
    seed: int = 0,
) -> RenderSettings:
    """What a picture of a sheet is asked for.

    Args:
        renderer: A registered renderer.
        options: What is asked of it, by the names that it declares.
        denoise: Whether noise is taken away.
        samples: Samples a pixel.
        size: Pixels along each side.
        seed: Fixes the noise.
    """
    return RenderSettings(
        renderer=renderer,
        options=options,
        channels=(SOURCE,),
        denoise=denoise,
        samples=samples,
        resolution=(size, size),
        seed=seed,
        bounces=_BOUNCES,
        method="reference",
    )


def photograph(opened: "RenderContext", camera: str, times: int = 1) -> Bytes:
    """(size, size, 3) the exposed picture of a camera.

    Args:
        opened: A stage, opened with `photograph_settings`.
        camera: The camera's prim path.
        times: So many times the samples.

    Raises:
        RenderError: The renderer cannot do it.
    """
    request = opened.request(camera, samples=times * (opened.settings.samples or 1))
    view = opened.render(request)
    denoiser = opened.plan.denoiser
    if denoiser:
        view = denoiser.complete(view)
    shown = view.images[DENOISED if denoiser else SOURCE].pixels
    return preview(SOURCE, shown, view.exposure, "film").pixels
