"""A stage that Mitsuba has opened: its cameras are rendered into channels."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, Final

import mitsuba as mi
from pxr import Usd

from openrooms_usd.channels import CHANNELS, RENDERED, each, numbered
from openrooms_usd.errors import RenderError
from openrooms_usd.render import Image, RenderRequest, View
from openrooms_usd.render.contract import Bsdf
from openrooms_usd.render.probes import ProbeRequest
from openrooms_usd.usd.cameras import PinholeCamera, framing_camera, list_cameras, read_camera
from orusd_mitsuba.build import Builder
from orusd_mitsuba.direct_light import DirectFilm
from orusd_mitsuba.first_hits import first_hits
from orusd_mitsuba.ground_truth import GroundTruth
from orusd_mitsuba.hemispheres import HemisphereFilm, coarse
from orusd_mitsuba.light_film import LightFilm
from orusd_mitsuba.light_records import light_masks, light_records
from orusd_mitsuba.path_film import PathFilm
from orusd_mitsuba.probes import render_probes
from orusd_mitsuba.rays import RayTracer
from orusd_mitsuba.resolution import stage_resolution
from orusd_mitsuba.sampling import Halves
from orusd_mitsuba.sensors import clipping_loss
from orusd_mitsuba.sources import Filing, sources_of
from orusd_mitsuba.takes import AROUND, PICTURE, RECEIVED, STRAIGHT, Film, Take, run_take
from orusd_mitsuba.translate import translate
from orusd_mitsuba.variants import Backend
from orusd_mitsuba.white import white_first

Progress = Callable[[float], None]

# Those that take less time first.
_TAKES: Final = (PICTURE, RECEIVED, STRAIGHT, AROUND)
# The part of the progress that geometry takes beside many samples.
_GEOMETRY: Final = 0.02


class MitsubaSession:
    """A stage that is translated once and rendered from any of its cameras.

    Args:
        stage: The composed stage.
        backend: What `orusd_mitsuba.variants.choose` found.
        bsdf: How surfaces shall reflect.

    Attributes:
        backend: What computes, for the record.
        bsdf: How surfaces reflect.
        advice: What would make it faster; empty when nothing would.
        cameras: Prim paths of the stage's cameras, sorted.
        resolution: Width and height that the stage asks for.
        legend: What the label numbers mean.
        report: What became of every prim.
    """

    def __init__(self, stage: Usd.Stage, backend: Backend, bsdf: Bsdf = "auto") -> None:
        self._variant = backend.variant
        self._activate()
        self._stage = stage
        self.bsdf = _affordable(bsdf, backend)
        self._scene = translate(stage, self.bsdf)
        self._builder = Builder(self._scene.origin)
        self._built = self._builder.scene(self._scene)
        self._sources = sources_of(self._scene)
        self.lights = light_records(stage, self._scene, self._sources)
        self._tracer = RayTracer(self._scene, self._built)
        self.backend = f"mitsuba {mi.__version__} {backend.variant}"
        self.advice = backend.advice
        cameras = list_cameras(stage)
        self.cameras = tuple(str(prim.GetPath()) for prim in cameras)
        self.resolution = stage_resolution(stage)
        self.legend = self._scene.legend
        self.report = self._scene.report
        for prim in cameras:
            if loss := clipping_loss(prim):
                self.report.add(prim.GetPath(), "approximated", loss)

    def render(self, request: RenderRequest, progress: Progress = lambda fraction: None) -> View:
        """Render one camera.

        Args:
            request: What to render.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: A channel or the camera does not exist.
            StageError: The camera cannot make a picture.
        """
        self._activate()
        _check(request, self._variant)
        progress(0.0)
        camera = self._camera(request)
        lit = [name for name in request.channels if CHANNELS[name].kind == "light"]
        seen = [name for name in request.channels if name not in lit]
        images = self._seen(camera, request, seen)
        start = _GEOMETRY if seen and lit else 0.0
        if lit:
            images |= self._lit(camera, request, lit, lambda d: progress(start + (1.0 - start) * d))
        progress(1.0)
        return View(
            camera=request.camera,
            width=request.width,
            height=request.height,
            K=camera.K,
            world_from_camera=camera.world_from_camera,
            exposure=camera.exposure,
            images={name: images[name] for name in each(request.channels, len(self.lights))},
        )

    def probe(
        self, request: ProbeRequest, progress: Progress = lambda fraction: None
    ) -> tuple[Image, ...]:
        """Render the panoramas about points.

        Args:
            request: Where, and how.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: The backend cannot.
        """
        self._activate()
        if self._variant.startswith("scalar"):
            raise RenderError(
                f"the backend {self._variant} cannot make light probes",
                remedy="use --variant llvm (or cuda); `orusd doctor` says what this machine has",
            )
        return render_probes(self._built, self._filing, self._scene.origin, request, progress)

    def _activate(self) -> None:
        # Variants are chosen for the whole thread; another session may have changed it.
        mi.set_variant(self._variant)
        mi.set_log_level(mi.LogLevel.Error)

    def _camera(self, request: RenderRequest) -> PinholeCamera:
        if request.camera is None:
            return framing_camera(self._stage, request.width, request.height)
        if request.camera not in self.cameras:
            known = ", ".join(self.cameras) or "none; leave the camera away to frame the scene"
            raise RenderError("there is no such camera", place=request.camera, remedy=known)
        prim = self._stage.GetPrimAtPath(request.camera)
        return read_camera(prim, request.width, request.height)

    def _seen(
        self, camera: PinholeCamera, request: RenderRequest, channels: list[str]
    ) -> dict[str, Image]:
        """Channels of what the pixels' centres see; the ray that all share is in each's time."""
        if not channels:
            return {}
        start = time.perf_counter()
        hits = first_hits(self._scene, self._tracer, camera, request.width, request.height)
        truth = GroundTruth(self._scene, camera, hits)
        shared = time.perf_counter() - start
        images: dict[str, Image] = {}
        for name in channels:
            start = time.perf_counter()
            if name == "mask_i":
                masks = light_masks(self._scene, self._sources, camera, hits)
                made = {numbered(name, light): mask for light, mask in enumerate(masks)}
            else:
                made = {name: truth.channel(name)}
            seconds = shared + time.perf_counter() - start
            images |= {single: Image(pixels, 1, seconds, 0.0) for single, pixels in made.items()}
        return images

    def _lit(
        self, camera: PinholeCamera, request: RenderRequest, channels: list[str], progress: Progress
    ) -> dict[str, Image]:
        """Channels of light: each take that is needed, in equal parts of the time."""
        needed = [(take, found) for take in _TAKES if (found := take.gives(channels))]
        seconds = None if request.seconds is None else request.seconds / len(needed)
        part = replace(request, seconds=seconds)
        images: dict[str, Image] = {}
        for number, (take, found) in enumerate(needed):
            film = self._film(take, camera, request, found)
            share = partial(_share, progress, number, len(needed))
            given, halves = run_take(take, film, part, found, len(self.lights), share)
            images |= given
            self._note(request, take.name, halves, int(film.broken.sum()))
        return images

    def _film(
        self, take: Take, camera: PinholeCamera, request: RenderRequest, channels: tuple[str, ...]
    ) -> Film:
        size = request.width, request.height
        if self._variant.startswith("scalar"):
            return PathFilm(self._built, camera, request, self._scene.origin)
        if take is STRAIGHT:
            return DirectFilm(
                self._scene, self._built, self._sources, self._filing, self._white, camera, *size
            )
        if take is AROUND:
            seen = replace(camera, K=coarse(camera, size, request.grid))
            return HemisphereFilm(
                self._scene, self._built, self._filing, self._tracer, seen, request.grid,
                request.bounces + 1,
            )  # fmt: skip
        return LightFilm(
            self._built, self._filing, camera, *size, self._scene.origin, request.bounces + 1,
            by_light=any(CHANNELS[name].scope == "light" for name in channels),
            first=self._white if take is RECEIVED else None,
        )  # fmt: skip

    @cached_property
    def _filing(self) -> Filing:
        return Filing(self._sources, self._built, self._scene.origin)

    @cached_property
    def _white(self) -> Callable[[Any], Any]:
        return white_first(self._scene, self._built, self._builder)

    def _note(self, request: RenderRequest, what: str, halves: Halves, replaced: int) -> None:
        where = request.camera or "framing camera"
        if request.error is not None and (halves.error or 0.0) > request.error:
            reason = (
                f"{what}: estimated error {halves.error:.2g} after {halves.total} samples a pixel, "
                f"not {request.error:g}"
            )
            self.report.add(where, "approximated", reason)
        if replaced:
            reason = f"{what} was no number in {replaced} pixels, taken as 0"
            self.report.add(where, "approximated", reason)


def _share(progress: Progress, number: int, count: int, done: float) -> None:
    """The progress of one take as that of all."""
    progress((number + done) / count)


def _affordable(bsdf: Bsdf, backend: Backend) -> Bsdf:
    """``auto`` as a backend can have it: a scalar one would call Python for every scattering."""
    return "preview" if bsdf == "auto" and backend.variant.startswith("scalar") else bsdf


def _check(request: RenderRequest, variant: str) -> None:
    unknown = sorted(set(request.channels) - set(RENDERED))
    if unknown:
        raise RenderError(
            f"Mitsuba gives no channel {', '.join(unknown)}", remedy=f"one of {', '.join(RENDERED)}"
        )
    simple = variant.startswith("scalar")
    if many := [n for n in request.channels if simple and CHANNELS[n].extra and n != "mask_i"]:
        raise RenderError(
            f"the backend {variant} cannot give {', '.join(many)}",
            remedy="use --variant llvm (or cuda); `orusd doctor` says what this machine has",
        )
    if request.width < 1 or request.height < 1 or request.bounces < 0:
        raise RenderError(
            f"no picture has {request.width}x{request.height} pixels and {request.bounces} bounces",
            remedy="give a positive resolution and no negative number of bounces",
        )
