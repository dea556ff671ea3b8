"""Renders a camera path: frame by frame, steady in time, into a video with its ground truth."""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.contract import RenderRequest, View
from openrooms_usd.rendering.denoise import Denoiser
from openrooms_usd.rendering.estimates import Halves
from openrooms_usd.rendering.paths import reprojection
from openrooms_usd.rendering.paths.accumulation import Accumulation, divisor_of
from openrooms_usd.rendering.paths.camera_path import CameraPath
from openrooms_usd.rendering.paths.reprojection import Surfaces, reproject
from openrooms_usd.rendering.paths.steadiness import flicker
from openrooms_usd.rendering.tone import Tone, fitted_tone

Pixels = NDArray[np.float32]

LIGHT: Final = "radiance"
BASE: Final = "base_color"
NORMAL: Final = "normal"
EXACT: Final = (*reprojection.CHANNELS, BASE, NORMAL, "depth")
DEFAULT_SAMPLES: Final = 4

# The first frame has no history: samples in its place. And where much is new, more than usual.
_FIRST_FRAMES: Final = 8
_MOST_EXTRA_FRAMES: Final = 3
# Frames along the path, small, that its exposure is fitted to.
_EXPOSURE_FRAMES: Final = 8
_EXPOSURE_PIXELS_WIDE: Final = 64
_EXPOSURE_SAMPLES: Final = 16


@dataclass(frozen=True, eq=False)
class Frame:
    """A finished frame.

    Attributes:
        view: Its exact channels, and as ``radiance`` what its own samples say.
        pixels: (H, W, 3) scene-linear, what is shown: accumulated, and denoised where that was
            asked for.
        error: Estimated relative mean squared error of the accumulated radiance.
        flicker: See `openrooms_usd.rendering.paths.steadiness.flicker`; None for the first.
        new: The part of its pixels that the frame before did not see.
        samples: A pixel.
        seconds: What it took, by step.
    """

    view: View
    pixels: Pixels
    error: float | None
    flicker: float | None
    new: float
    samples: int
    seconds: Mapping[str, float]


def frames(
    opened: RenderContext, path: CameraPath, request: RenderRequest, denoiser: Denoiser | None
) -> Iterator[Frame]:
    """Render the frames of a path, each with what the earlier ones know.

    Args:
        opened: The stage.
        path: Where the camera is.
        request: Size, samples a frame, and how light is computed.
        denoiser: What takes the rest of the noise; None for none.
    """
    light, shown = Accumulation(), Accumulation()
    before: tuple[Surfaces, Pixels] | None = None
    usual = request.samples or DEFAULT_SAMPLES
    for number, camera in enumerate(path.cameras):
        clock = _Clock()
        asked = replace(request, camera=path.frame_name(number))
        view = opened.picture(camera, replace(asked, channels=EXACT))
        surfaces = Surfaces.of(view)
        guides = opened.guides(camera, asked)
        base = _divisible(guides[BASE], view)
        clock.lap("exact")
        taps = reproject(surfaces, before[0]) if before else None
        new = float(1.0 - taps.found.mean()) if taps else 1.0
        clock.lap("reprojection")
        worth = 1 + round(new * _MOST_EXTRA_FRAMES) if taps else _FIRST_FRAMES
        asked = replace(
            asked, channels=(LIGHT,), samples=usual * worth, halves=True, measure_bias=number == 0
        )
        image = opened.picture(camera, asked).images[LIGHT]
        clock.lap("light")
        halves = light.add(
            image.halves.halves if image.halves else Halves(image.pixels, image.pixels, (1, 1)),
            base,
            taps,
            worth,
        )
        pixels = _mean(halves)
        clock.lap("accumulation")
        if denoiser:
            clean = denoiser.denoise(image.pixels, guides)
            pixels = _mean(shown.add(Halves(clean, clean, (1, 1)), base, taps, worth))
            clock.lap("denoising")
        # Of a texture a pixel shows now this part and now that one: only light can flicker.
        received = np.asarray(pixels / divisor_of(base), dtype=np.float32)
        moved = flicker(received, before[1], taps) if before and taps else None
        images = {**view.images, LIGHT: replace(image, halves=None)}
        before = surfaces, received
        yield Frame(
            replace(view, images=images),
            pixels,
            halves.error,
            moved,
            new,
            usual * worth,
            clock.seconds,
        )


def path_tone(opened: RenderContext, path: CameraPath, request: RenderRequest) -> Tone:
    """One tone for all frames, fitted to small ones along the path; with the camera's exposure."""
    scale = min(1.0, _EXPOSURE_PIXELS_WIDE / request.width)
    small = [max(2, round(side * scale)) for side in (request.width, request.height)]
    K = np.diag([small[0] / request.width, small[1] / request.height, 1.0]) @ path.K
    chosen = np.unique(np.linspace(0, len(path) - 1, _EXPOSURE_FRAMES).round().astype(int))
    asked = replace(
        request,
        width=small[0],
        height=small[1],
        channels=(LIGHT,),
        samples=_EXPOSURE_SAMPLES,
        measure_bias=False,
    )
    strip = []
    for number, camera in enumerate(path.cameras):
        if number in chosen:
            named = replace(asked, camera=f"{path.frame_name(number)}/exposure")
            view = opened.picture(replace(camera, K=K), named)
            strip.append(view.images[LIGHT].pixels)
    return fitted_tone(opened.settings.tone, np.concatenate(strip), path.exposure)


def _divisible(base_color: Pixels, view: View) -> Pixels:
    """(H, W, 3) what light is divided by: the base colour, and of the surroundings white."""
    there = view.images["valid"].pixels > 0
    return np.where(there, base_color, np.float32(1.0)).astype(np.float32)


def _mean(halves: Halves) -> Pixels:
    a, b = halves.samples
    return np.asarray((a * halves.a + b * halves.b) / (a + b), dtype=np.float32)


class _Clock:
    """Seconds of the steps of a frame."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, step: str) -> None:
        now = time.perf_counter()
        self.seconds[step], self._last = now - self._last, now
