"""A path-traced picture of what a page shows, made beside it, round by round."""

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from pydantic import Field

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.description.model import Model, Number, Switch, Whole
from openrooms_usd.description.rendering import PHOTOGRAPH, REFERENCE, RenderSettings
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering.color import quantize
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.contract import View
from openrooms_usd.rendering.denoise import load_denoiser
from openrooms_usd.rendering.opening import load_renderer, open_for_rendering
from openrooms_usd.rendering.tone import fitted_tone
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.usd.cameras import PinholeCamera
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.view.app import STAGES, Nothing

Row = Annotated[list[Number], Field(min_length=4, max_length=4)]
Three = Annotated[list[Number], Field(min_length=3, max_length=3)]
Matrix = Annotated[list[Row], Field(min_length=4, max_length=4)]

PICTURE: Final = "traced.png"
# Samples of the first round; each of the others doubles what there is.
_FIRST_SAMPLES: Final = 4
_CAMERA: Final = "the page"
# Between two looks whether the stages are free or the picture is wanted no more, seconds.
_TURN_S: Final = 0.1


class Trace(Model):
    """What is asked for."""

    world_from_camera: Matrix
    """OpenCV axes, metres."""
    focal: Annotated[Number, Field(gt=0.0, lt=1e3)]
    """Of the lens, in parts of the picture's width."""
    right: Number = 0.0
    """Where its axis meets the picture: right of the middle, in parts of the width."""
    down: Number = 0.0
    """Likewise, down."""
    width: Annotated[Whole, Field(ge=16, le=4096)]
    """Pixels."""
    height: Annotated[Whole, Field(ge=16, le=4096)]
    """Pixels."""
    samples: Annotated[Whole, Field(ge=1, le=65536)] = 64
    """Paths for each pixel."""
    denoise: Switch = False
    """Whether noise is taken away at the end."""
    moves: dict[str, Matrix] = Field(default_factory=dict)
    """Prims that stand elsewhere: of the world to the world."""
    weights: dict[str, Three] = Field(default_factory=dict)
    """What the light of lamps and openings is multiplied with, by their names."""


@dataclass
class Tracing:
    """Makes one picture at a time, in a thread of its own; a new one ends the one before.

    Attributes:
        path: The stage.
        settings: What renders, and how.
    """

    path: Path
    settings: RenderSettings = field(default_factory=RenderSettings)
    _opened: tuple[tuple[int, ...], RenderContext] | None = None
    _stop: threading.Event = field(default_factory=threading.Event)
    _thread: threading.Thread | None = None
    _told: dict[str, Any] = field(default_factory=lambda: {"state": "nothing"})
    _picture: bytes = b""

    def start(self, asked: Trace) -> dict[str, Any]:
        """Begin with a picture.

        Raises:
            MissingPackageError: The renderer or the denoiser is not installed.
        """
        load_renderer(self.settings)
        if asked.denoise:
            load_denoiser()
        self.stop(Nothing())
        self._stop = threading.Event()
        self._told = {"state": "opening", "samples": 0, "fraction": 0.0}
        self._thread = threading.Thread(target=self._run, args=(asked, self._stop), daemon=True)
        self._thread.start()
        return self._told

    def stop(self, _: Nothing) -> dict[str, Any]:
        """End with what there is."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
        return self._told

    def told(self, _: Nothing) -> dict[str, Any]:
        """How far it is: ``state``, ``samples``, ``fraction``, and ``error`` where it failed."""
        return self._told

    def picture(self) -> bytes:
        """What there is of it, as a PNG.

        Raises:
            InputError: There is none yet.
        """
        if not self._picture:
            raise InputError("there is no picture yet", remedy="trace one")
        return self._picture

    def _run(self, asked: Trace, stop: threading.Event) -> None:
        try:
            self._trace(asked, stop)
        except OrusdError as error:
            self._told = {**self._told, "state": "failed", "error": error.as_dict()}
        except Exception as error:
            # A thread has no caller to raise it to, and the page waits.
            said = {"message": f"the renderer failed: {error}", "place": None, "remedy": None}
            self._told = {**self._told, "state": "failed", "error": said}

    def _trace(self, asked: Trace, stop: threading.Event) -> None:
        opened = self._stage(stop)
        if opened is None:
            self._told = {"state": "ready", "samples": 0, "fraction": 0.0}
            return
        opened.move({path: np.array(matrix) for path, matrix in asked.moves.items()})
        camera, done, total = _camera(asked), 0, np.zeros((asked.height, asked.width, 3))
        guides: Mapping[str, Floats] = {}
        while done < asked.samples and not stop.is_set():
            now = min(max(done, _FIRST_SAMPLES), asked.samples - done)
            request = opened.request(
                _CAMERA,
                channels=("radiance_i",) if asked.weights else ("radiance",),
                width=asked.width,
                height=asked.height,
                samples=now,
                seed=done,
                method=self.settings.method or REFERENCE,
                measure_bias=False,
                halves=False,
                guides=asked.denoise and not guides,
            )

            def tell(share: float, first: int = done, count: int = now) -> None:
                fraction = (first + share * count) / asked.samples
                self._told = {"state": "tracing", "samples": first, "fraction": fraction}

            view = opened.picture(camera, request, tell)
            guides = guides or view.guides
            total += now * _light(view, opened, asked)
            done += now
            self._show((total / done).astype(np.float32), done, asked)
        if asked.denoise and done:
            clean = load_denoiser().denoise((total / done).astype(np.float32), guides)
            self._show(clean, done, asked)
        self._told = {"state": "ready", "samples": done, "fraction": done / asked.samples}

    def _stage(self, stop: threading.Event) -> RenderContext | None:
        """The stage as it is now, opened anew where a file of it has changed; None when stopped."""
        # Who stops this thread may hold the stages, and waits for it.
        while not STAGES.acquire(timeout=_TURN_S):
            if stop.is_set():
                return None
        try:
            stage = open_stage(self.path)
            files = [layer.realPath for layer in stage.GetLayerStack() if layer.realPath]
            stamps = tuple(Path(file).stat().st_mtime_ns for file in files)
            if self._opened is None or self._opened[0] != stamps:
                opened = open_for_rendering(self.path, self.settings)
                # Read here: pictures are made while others have the stages.
                _ = opened.lights
                self._opened = stamps, opened
            return self._opened[1]
        finally:
            STAGES.release()

    def _show(self, radiance: Floats, samples: int, asked: Trace) -> None:
        tone = fitted_tone(PHOTOGRAPH, radiance)
        codes = quantize(srgb_from_linear(tone.shown(radiance)))
        with scratch_folder() as folder:
            write_png(folder / PICTURE, codes)
            self._picture = (folder / PICTURE).read_bytes()
        self._told = {"state": "tracing", "samples": samples, "fraction": samples / asked.samples}


def _camera(asked: Trace) -> PinholeCamera:
    focal = asked.focal * asked.width
    K = np.array(
        [
            [focal, 0.0, (0.5 + asked.right) * asked.width],
            [0.0, focal, 0.5 * asked.height + asked.down * asked.width],
            [0.0, 0.0, 1.0],
        ]
    )
    return PinholeCamera(K, np.array(asked.world_from_camera))


def _light(view: View, opened: RenderContext, asked: Trace) -> Array:
    """(H, W, 3) nits, each light as the page has it."""
    if not asked.weights:
        return view.images["radiance"].pixels.astype(np.float64)
    weights = [asked.weights.get(light.name, [1.0, 1.0, 1.0]) for light in opened.lights]
    images = [view.images[f"radiance_{light.number}"].pixels for light in opened.lights]
    parts = [image * np.array(weight) for image, weight in zip(images, weights, strict=True)]
    return np.asarray(np.sum(parts, axis=0), np.float64)
