"""One picture of one camera, as sheets show it."""

from typing import TYPE_CHECKING, Final

from openrooms_usd.render.contract import RenderRequest
from openrooms_usd.render.denoise import DENOISED, SOURCE, Denoiser
from openrooms_usd.render.previews import Bytes, preview

if TYPE_CHECKING:
    from openrooms_usd.render.opened import OpenedStage

_BOUNCES: Final = 4


def photograph(
    opened: "OpenedStage",
    camera: str,
    size: int,
    samples: int,
    seed: int,
    denoiser: Denoiser | None,
) -> Bytes:
    """(size, size, 3) the exposed picture of a camera.

    Args:
        opened: What a renderer opened.
        camera: The camera's prim path.
        size: Pixels along each side.
        samples: Samples a pixel.
        seed: Fixes the noise.
        denoiser: What takes the noise away; None leaves it.

    Raises:
        RenderError: The renderer cannot do it.
    """
    request = RenderRequest(
        camera, (SOURCE,), size, size, samples=samples, seed=seed, bounces=_BOUNCES,
        guides=denoiser is not None,
    )  # fmt: skip
    view = opened.render(request)
    if denoiser:
        view = denoiser.complete(view)
    shown = view.images[DENOISED if denoiser else SOURCE].pixels
    return preview(SOURCE, shown, view.exposure, "film").pixels
