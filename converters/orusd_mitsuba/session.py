"""A stage that Mitsuba has opened: its cameras are rendered into channels."""

import time
from collections.abc import Callable
from typing import Any, Final

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from openrooms_usd.channels import CHANNELS, RENDERED
from openrooms_usd.errors import RenderError
from openrooms_usd.render import Image, RenderRequest, View
from openrooms_usd.render.contract import Bsdf
from openrooms_usd.usd.cameras import PinholeCamera, framing_camera, list_cameras, read_camera
from orusd_mitsuba.build import Builder, load_sensor
from orusd_mitsuba.first_hits import first_hits
from orusd_mitsuba.ground_truth import GroundTruth
from orusd_mitsuba.rays import RayTracer
from orusd_mitsuba.resolution import stage_resolution
from orusd_mitsuba.sampling import Halves, Sampler
from orusd_mitsuba.sensors import clipping_loss, describe_sensor
from orusd_mitsuba.translate import translate
from orusd_mitsuba.variants import Backend

Progress = Callable[[float], None]

# Paths in flight at once; each takes some 200 bytes of memory.
_WAVEFRONT: Final = 1 << 22
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
        self._built = Builder(self._scene.origin).scene(self._scene)
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
        _check(request)
        progress(0.0)
        camera = self._camera(request)
        kinds = {name: CHANNELS[name].kind for name in request.channels}
        lit = [name for name, kind in kinds.items() if kind == "light"]
        seen = [name for name, kind in kinds.items() if kind != "light"]
        images = self._seen(camera, request, seen)
        start = _GEOMETRY if seen and lit else 0.0
        if lit:
            images |= self._radiance(
                camera, request, lambda done: progress(start + (1.0 - start) * done)
            )
        progress(1.0)
        return View(
            camera=request.camera,
            width=request.width,
            height=request.height,
            K=camera.K,
            world_from_camera=camera.world_from_camera,
            exposure=camera.exposure,
            images={name: images[name] for name in request.channels},
        )

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
        images = {}
        for name in channels:
            start = time.perf_counter()
            pixels = truth.channel(name)
            images[name] = Image(pixels, 1, shared + time.perf_counter() - start, 0.0)
        return images

    def _radiance(
        self, camera: PinholeCamera, request: RenderRequest, progress: Progress
    ) -> dict[str, Image]:
        start = time.perf_counter()
        film = _Film(self._built, camera, request, self._scene.origin)
        most = max(1, _WAVEFRONT // (request.width * request.height))
        shape = request.height, request.width
        halves = Sampler(film, request, shape, most, progress).run()
        replaced = int(film.broken.sum())
        self._note(request, halves, replaced)
        seconds = time.perf_counter() - start
        return {"radiance": Image(halves.mean, halves.total, seconds, halves.error, replaced)}

    def _note(self, request: RenderRequest, halves: Halves, replaced: int) -> None:
        where = request.camera or "framing camera"
        if request.error is not None and (halves.error or 0.0) > request.error:
            reason = (
                f"estimated error {halves.error:.2g} after {halves.total} samples a pixel, "
                f"not {request.error:g}"
            )
            self.report.add(where, "approximated", reason)
        if replaced:
            reason = f"radiance was no number in {replaced} pixels, taken as 0"
            self.report.add(where, "approximated", reason)


def _affordable(bsdf: Bsdf, backend: Backend) -> Bsdf:
    """``auto`` as a backend can have it: a scalar one would call Python for every scattering."""
    return "preview" if bsdf == "auto" and backend.variant.startswith("scalar") else bsdf


class _Film:
    """Renders passes of a camera, in bands of rows where one pass would take too much memory.

    Attributes:
        broken: (height, width) bool, pixels in which a pass gave no number.
    """

    def __init__(
        self, built: Any, camera: PinholeCamera, request: RenderRequest, origin: NDArray[np.float64]
    ) -> None:
        self._built = built
        self._integrator = mi.load_dict({"type": "path", "max_depth": request.bounces + 1})
        rows = max(1, _WAVEFRONT // request.width)
        self._bands = [
            load_sensor(
                describe_sensor(
                    camera,
                    request.width,
                    request.height,
                    origin,
                    (top, min(rows, request.height - top)),
                ),
                {"type": "independent"},
            )
            for top in range(0, request.height, rows)
        ]
        self.broken = np.zeros((request.height, request.width), dtype=bool)

    def __call__(self, samples: int, seed: int) -> NDArray[np.float32]:
        bands = [
            mi.render(
                self._built,
                sensor=sensor,
                integrator=self._integrator,
                spp=samples,
                seed=(seed + number) & 0xFFFFFFFF,
            ).numpy()
            for number, sensor in enumerate(self._bands)
        ]
        pixels = np.concatenate(bands)
        finite = np.isfinite(pixels)
        self.broken |= ~finite.all(axis=2)
        return np.where(finite, pixels, np.float32(0.0))


def _check(request: RenderRequest) -> None:
    unknown = sorted(set(request.channels) - set(RENDERED))
    if unknown:
        raise RenderError(
            f"Mitsuba gives no channel {', '.join(unknown)}", remedy=f"one of {', '.join(RENDERED)}"
        )
    if request.width < 1 or request.height < 1 or request.bounces < 0:
        raise RenderError(
            f"no picture has {request.width}x{request.height} pixels and {request.bounces} bounces",
            remedy="give a positive resolution and no negative number of bounces",
        )
