"""Renders a camera path: frame by frame, steady in time, into a video with its ground truth."""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Floats
from openrooms_usd.colorimetry import LUMINANCE
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.contract import RenderRequest, View
from openrooms_usd.rendering.denoise import Denoiser
from openrooms_usd.rendering.estimates import Halves
from openrooms_usd.rendering.paths import reprojection
from openrooms_usd.rendering.paths.camera_path import CameraPath
from openrooms_usd.rendering.paths.reprojection import Taps, VisibleSurfaces, reproject
from openrooms_usd.rendering.tone import Tone, fitted_tone

# Frames after which what is older counts no more than what is new.
LONGEST_HISTORY_FRAMES: Final = 32.0
_CLAMP_DEVIATIONS: Final = 2.0
_NEIGHBOURS_PIXELS: Final = 3  # to each side
# Light per base colour is not defined for black surfaces.
_LEAST_BASE_COLOR: Final = 0.04

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
class FilmFrame:
    """A finished frame.

    Attributes:
        view: Its exact channels, and as ``radiance`` what its own samples say.
        pixels: (H, W, 3) scene-linear, what is shown: accumulated, and denoised where that was
            asked for.
        error: Estimated relative mean squared error of the accumulated radiance.
        flicker: See `openrooms_usd.rendering.paths.film.flicker`; None for the first.
        new: The part of its pixels that the frame before did not see.
        samples: A pixel.
        seconds: What it took, by step.
    """

    view: View
    pixels: Floats
    error: float | None
    flicker: float | None
    new: float
    samples: int
    seconds: Mapping[str, float]


def frames(
    opened: RenderContext, path: CameraPath, request: RenderRequest, denoiser: Denoiser | None
) -> Iterator[FilmFrame]:
    """Render the frames of a path, each with what the earlier ones know.

    Args:
        opened: The stage.
        path: Where the camera is.
        request: Size, samples a frame, and how light is computed.
        denoiser: What takes the rest of the noise; None for none.
    """
    light, shown = Accumulation(), Accumulation()
    before: tuple[VisibleSurfaces, Floats] | None = None
    usual = request.samples or DEFAULT_SAMPLES
    for number, camera in enumerate(path.cameras):
        clock = _Clock()
        asked = replace(request, camera=path.frame_name(number))
        view = opened.picture(camera, replace(asked, channels=EXACT))
        surfaces = VisibleSurfaces.of(view)
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
        yield FilmFrame(
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


def _divisible(base_color: Floats, view: View) -> Floats:
    """(H, W, 3) what light is divided by: the base colour, and of the surroundings white."""
    there = view.images["valid"].pixels > 0
    return np.where(there, base_color, np.float32(1.0)).astype(np.float32)


def _mean(halves: Halves) -> Floats:
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


def flicker(now: Floats, before: Floats, taps: Taps) -> float:
    """The noise that two frames show at the same places, relative to their light.

    The root mean square of the change of luminance over the surfaces that both see, relative to
    sqrt(m^2 + 0.01 M^2) and over sqrt(2). m is their mean there and M that of the picture. For two
    frames with independent errors it is the relative standard error of one of them.

    Args:
        now: (H, W, 3) a frame, without its textures.
        before: (H, W, 3) the frame before it.
        taps: Where what ``now`` sees was in ``before``.

    Returns:
        0 where nothing is seen by both.
    """
    fresh = now.reshape(-1, 3) @ LUMINANCE
    old = taps((before.reshape(-1, 3) @ LUMINANCE).astype(np.float32))
    both = taps.found
    if not both.any():
        return 0.0
    mean = 0.5 * (fresh + old)
    scale = mean**2 + 0.01 * fresh.mean() ** 2
    change = np.divide((fresh - old) ** 2, scale, out=np.zeros_like(scale), where=scale > 0.0)
    return float(np.sqrt(change[both].mean() / 2.0))


# The radiance of a frame is divided by the base colour, so that textures stay sharp, and mixed
# with what earlier frames found at the same places of the same surfaces (`reprojection`). A
# mirror image moves otherwise than the mirror: history that is far from what a pixel's neighbours
# show now is drawn towards them (K. Karis, High quality temporal supersampling, SIGGRAPH 2014;
# the mean and deviation of the neighbourhood after M. Salvi, GDC 2016). Both halves of the
# samples are carried along alike, so that their difference tells the error of what comes out.
class Accumulation:
    """The light of the surfaces of the last frame.

    Args:
        longest: Frames that history counts at most.
    """

    def __init__(self, longest: float = LONGEST_HISTORY_FRAMES) -> None:
        self._longest = longest
        self._halves: list[Floats] = []
        self._frames: Floats = np.zeros(0, np.float32)

    def add(
        self, halves: Halves, base_color: Floats, taps: Taps | None, frames: float = 1
    ) -> Halves:
        """Add a frame.

        Args:
            halves: Two independent estimates of its radiance, (H, W, 3).
            base_color: (H, W, 3).
            taps: Where its surfaces were in the last frame; None for the first.
            frames: How many frames' samples it has.

        Returns:
            The halves of the radiance with what is known from before.
        """
        shape = base_color.shape
        divisor = divisor_of(base_color).reshape(-1, 3)
        now: list[Floats] = [
            np.asarray(half.reshape(-1, 3) / divisor, dtype=np.float32)
            for half in (halves.a, halves.b)
        ]
        if taps is None:
            self._halves, self._frames = now, np.full(len(divisor), frames, np.float32)
        else:
            known = np.where(taps.found, taps(self._frames), np.float32(0.0))
            known = np.minimum(known, np.float32(self._longest - frames))
            before = _near([taps(half) for half in self._halves], now, shape[:2])
            share = (np.float32(frames) / (known + np.float32(frames)))[:, None]
            self._halves = [
                np.asarray(old + share * (new - old), dtype=np.float32)
                for old, new in zip(before, now, strict=True)
            ]
            self._frames = known + np.float32(frames)
        a, b = ((half * divisor).reshape(shape) for half in self._halves)
        return Halves(a, b, halves.samples)


def divisor_of(base_color: Floats) -> Floats:
    """(..., 3) what light is divided by, so that textures stay out of what is added up."""
    return np.maximum(base_color, np.float32(_LEAST_BASE_COLOR))


def _near(before: list[Floats], now: list[Floats], shape: tuple[int, int]) -> list[Floats]:
    """History, clamped to the neighbourhood of a pixel."""
    fresh, old = (np.float32(0.5) * (a + b) for a, b in (now, before))
    picture = fresh.reshape(*shape, 3)
    mean = _blurred(picture)
    deviation = np.sqrt(np.maximum(_blurred(picture**2) - mean**2, 0.0))
    reach = np.float32(_CLAMP_DEVIATIONS) * deviation
    low, high = ((mean + side * reach).reshape(-1, 3) for side in (-1, 1))
    shift = np.clip(old, low, high) - old
    return [half + shift for half in before]


def _blurred(picture: Floats) -> Floats:
    """(H, W, 3) means over the pixels around each; fewer at the edges."""
    for axis in (0, 1):
        size, reach = picture.shape[axis], _NEIGHBOURS_PIXELS
        sums = np.cumsum(picture, axis=axis, dtype=np.float64)
        sums = np.concatenate([np.zeros_like(sums.take([0], axis)), sums], axis=axis)
        last = np.minimum(np.arange(size) + reach + 1, size)
        first = np.maximum(np.arange(size) - reach, 0)
        counts = (last - first).reshape([-1 if a == axis else 1 for a in range(3)])
        picture = ((sums.take(last, axis) - sums.take(first, axis)) / counts).astype(np.float32)
    return picture
