"""Renders a camera path of a stage into files: a video, the cameras of its frames, and frames."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import atomic, claims, ledger
from openrooms_usd.description.rendering import CACHE, Method, RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.progress import Counted, Progress, silent
from openrooms_usd.rendering import exr, folder, manifest
from openrooms_usd.rendering.contract import (
    DEFAULT_RATE,
    MethodicalSession,
    RenderRequest,
    RenderSession,
)
from openrooms_usd.rendering.denoise import DENOISED, Denoiser
from openrooms_usd.rendering.given import choose_method
from openrooms_usd.rendering.paths import video
from openrooms_usd.rendering.paths.camera_path import CameraPath
from openrooms_usd.rendering.paths.choosing import choose_path
from openrooms_usd.rendering.paths.film import (
    DEFAULT_SAMPLES,
    EXACT,
    LIGHT,
    FilmFrame,
    frames,
    path_tone,
)
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.tone import Tone

DEFAULT_RESOLUTION: Final = (320, 240)
_RATES: Final = (1, 240)
_MOST_SECONDS: Final = 3600.0
CONVENTIONS: Final = {
    "estimated_error": "of what the samples of a frame and its history say, before denoising: the "
    "relative mean squared error, estimated from two separate halves",
    "flicker": "of the video, by base colour: root mean square of the change of luminance where "
    "a frame and the one before it see the same, over sqrt(m^2 + 0.01 M^2) and sqrt(2). m is its "
    "mean there and M that of the picture",
    "new": "the part of the pixels that the frame before did not see",
    "exposure": "what radiance in nits is multiplied by in the video, the same for all frames",
    "shows": "how light is shown in the video, the same for all frames",
}


@dataclass(frozen=True)
class PathSummary:
    """What was written of a path.

    Attributes:
        video: The video.
        cameras: The file with the cameras of its frames.
        frames: The folder of frames, where they were asked for.
        manifest: What stands in ``cameras``.
        timing: Mean seconds of the steps of a frame.
    """

    video: Path
    cameras: Path
    frames: Path | None
    manifest: Mapping[str, Any]
    timing: Mapping[str, float]

    def as_dict(self) -> dict[str, Any]:
        """The summary as plain data."""
        return {
            "video": str(self.video),
            "cameras": str(self.cameras),
            "frames": None if self.frames is None else str(self.frames),
            "manifest": self.manifest,
            "timing": self.timing,
        }


def render_path(
    path: Path,
    out: Path,
    spec: str,
    settings: RenderSettings | None = None,
    *,
    seconds: float | None = None,
    rate: int = DEFAULT_RATE,
    keep_frames: bool = False,
    progress: Progress = silent,
) -> PathSummary:
    """Render a camera path of a USD stage as a video.

    ``out`` then holds ``<name>.webm``, ``<name>.json`` with the camera of every frame,
    ``<name>_timing.json`` and, on request, ``<name>_frames`` with an EXR and a PNG of each.

    Args:
        path: The USD file.
        out: The folder to write.
        spec: ``walk``, the name of a camera with time samples, or a file with keys.
        settings: What is asked for; its resolution has even numbers, 320x240 by default, its
            samples are those of a frame, `DEFAULT_SAMPLES` by default, and its method is ``cache``
            by default where the renderer has it.
        seconds: How long; by default as long as the path is, ten seconds for a walk.
        rate: Frames a second.
        keep_frames: Whether to write every frame too.
        progress: Called with the path's name and the finished fraction.

    Raises:
        InputError: There is no such path, or a number is absurd.
        MissingPackageError: What encodes videos, or the denoiser, is not installed.
        OutputError: The folder cannot be written, or holds other files of these names.
        RenderError: There is no room for a walk, or the renderer cannot do it.
    """
    from openrooms_usd.rendering.opening import check_settings, load_renderer, open_for_rendering

    # 1. Refuse what cannot work before anything slow begins.
    settings = settings or RenderSettings()
    size = settings.resolution or DEFAULT_RESOLUTION
    settings = settings.replace(
        channels=(LIGHT,), resolution=size, samples=settings.samples or DEFAULT_SAMPLES
    )
    _check(seconds, rate)
    video.check(size)
    if LIGHT not in load_renderer(settings).channels:
        raise InputError(
            f"the renderer {settings.renderer} does not compute light", place="renderer"
        )
    denoiser = check_settings(settings).denoiser
    folder.check_writable(out)

    # 2. Translate the stage, and find the path.
    opened = open_for_rendering(path, settings)
    request = opened.request(method=_method(settings.method, opened.session), guides=False)
    camera_path = choose_path(spec, opened, size, seconds, rate)
    files = _Files(out, camera_path.name, keep_frames)

    # 3. Render frame by frame.
    with claims.claimed(out, ledger.RENDER_FILE):
        files.check()
        shown_by = path_tone(opened, camera_path, request)
        told, spent, bias = [], [], None
        with files.writing(size, rate) as writer:
            for number, frame in enumerate(frames(opened, camera_path, request, denoiser)):
                if found := frame.view.images[LIGHT].bias:
                    bias = asdict(found)
                writer.add(number, frame, shown_by, denoiser is not None)
                told.append(_frame_record(frame))
                spent.append(frame.seconds)
                what = Counted(camera_path.name, number + 1, len(camera_path))
                progress(what, what.number / what.total)
            shared = opened.entry(replace(request, channels=()))
            entry = shared | _entry(camera_path, request, shown_by, denoiser, told)
            entry["bias"] = bias
            timing = {step: float(np.mean([s[step] for s in spent])) for step in spent[0]}
            writer.tell(entry, timing)
    return PathSummary(
        files.video, files.cameras, files.frames if keep_frames else None, entry, timing
    )


def _check(seconds: float | None, rate: int) -> None:
    if seconds is not None and not 0.0 < seconds <= _MOST_SECONDS:
        raise InputError(f"a path cannot take {seconds:g} seconds", place="duration (--duration)")
    if not _RATES[0] <= rate <= _RATES[1]:
        wanted = f"between {_RATES[0]} and {_RATES[1]}"
        raise InputError(f"{rate} frames per second are not {wanted}", place="rate (--fps)")


def _method(asked: Method | None, session: RenderSession) -> Method:
    """As asked for; else what computes the light of a room once: a film has many frames of it."""
    can = isinstance(session, MethodicalSession) and CACHE in session.methods
    return choose_method(CACHE if asked is None and can else asked, session)


def _frame_record(frame: FilmFrame) -> dict[str, Any]:
    return {
        "world_from_camera": frame.view.world_from_camera.tolist(),
        "samples": frame.samples,
        "new": round(frame.new, 4),
        "estimated_error": frame.error,
        "flicker": frame.flicker,
    }


def _entry(
    path: CameraPath,
    request: RenderRequest,
    tone: Tone,
    denoiser: Denoiser | None,
    told: list[dict[str, Any]],
) -> dict[str, Any]:
    moved = [one["flicker"] for one in told if one["flicker"] is not None]
    error = float(np.mean([one["estimated_error"] for one in told]))
    return {
        "path": path.name,
        "rate": path.rate,
        "resolution": [request.width, request.height],
        "K": path.K.tolist(),
        "exposure": tone.exposure,
        "shows": tone.told(),
        "denoiser": denoiser.entry() if denoiser else None,
        "estimated_error": error,
        "flicker": {
            "mean": float(np.mean(moved)) if moved else None,
            "most": max(moved, default=None),
            "stated": float(np.sqrt(error)),
        },
        "conventions": {**manifest.CONVENTIONS, **CONVENTIONS},
        "frames": told,
    }


class _Files:
    """The files of a path in a folder."""

    def __init__(self, out: Path, name: str, keep_frames: bool) -> None:
        self.out, self.keep_frames = out, keep_frames
        self.video, self.cameras = out / f"{name}{video.SUFFIX}", out / f"{name}.json"
        self.timing, self.frames = out / f"{name}_timing.json", out / f"{name}_frames"

    def check(self) -> None:
        """See that nothing gives way but what an earlier run wrote.

        Raises:
            OutputError: It would.
        """
        frames = [self.frames] if self.keep_frames else []
        atomic.check_free([self.video, self.cameras, self.timing, *frames])

    @contextmanager
    def writing(self, size: tuple[int, int], rate: int) -> Iterator["_Writer"]:
        """What takes the frames; the files appear when all are there."""
        beside_frames = (
            atomic.replacing_folder(self.frames) if self.keep_frames else nullcontext(None)
        )
        with (
            atomic.replacing_files(self.out) as beside,
            beside_frames as inner,
            video.writing(beside / self.video.name, size, rate) as encoder,
        ):
            yield _Writer(encoder, inner, beside / self.cameras.name, beside / self.timing.name)


@dataclass(frozen=True)
class _Writer:
    """Takes frames, and what is to be said of them all."""

    encoder: video.Encoder
    frames: Path | None
    cameras: Path
    timing: Path

    def add(self, number: int, frame: FilmFrame, tone: Tone, is_denoised: bool) -> None:
        shown = preview(LIGHT, frame.pixels, tone=tone).pixels
        self.encoder.add(shown)
        if self.frames is not None:
            planes = {name: frame.view.images[name].pixels for name in (LIGHT, *EXACT)}
            if is_denoised:
                planes[DENOISED] = frame.pixels
            exr.write_channels(self.frames / f"frame_{number:04d}.exr", planes)
            write_png(self.frames / f"frame_{number:04d}.png", shown)

    def tell(self, entry: Mapping[str, Any], timing: Mapping[str, float]) -> None:
        manifest.write_json(self.cameras, dict(entry))
        manifest.write_json(self.timing, dict(timing))
