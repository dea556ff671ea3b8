"""A stage that is translated once and opened by a renderer: light is its part, all else the core's.

The core gives what one exact ray through each pixel's centre tells: geometry, materials and labels.
"""

import logging
import math
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import cache, cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from openrooms_usd.channels import each, numbered
from openrooms_usd.errors import RenderError
from openrooms_usd.geometry.focus import focus_distance
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.render.contract import (
    GUIDES,
    NO_OPTIONS,
    GuidingSession,
    Image,
    MovingSession,
    Renderer,
    RenderRequest,
    RenderSession,
    View,
    ViewProgress,
)
from openrooms_usd.render.given import EXACT, choose_method, remedy_for
from openrooms_usd.render.scene.arrays import Scene
from openrooms_usd.render.scene.cameras import clipping_loss, stage_resolution
from openrooms_usd.render.scene.first_hits import first_hits
from openrooms_usd.render.scene.flow import optical_flow
from openrooms_usd.render.scene.framing import framed, is_framed_here
from openrooms_usd.render.scene.ground_truth import GroundTruth
from openrooms_usd.render.scene.light_masks import light_masks
from openrooms_usd.render.scene.light_records import light_records
from openrooms_usd.render.scene.lights import LightRecord
from openrooms_usd.render.scene.moving import MovingScene
from openrooms_usd.render.scene.pictures import Array
from openrooms_usd.render.scene.rays import CastingTracer
from openrooms_usd.render.scene.sources import sources_of
from openrooms_usd.render.scene.translate import translate
from openrooms_usd.usd.cameras import (
    PINHOLE,
    PinholeCamera,
    framing_camera,
    list_cameras,
    read_camera,
    with_lens,
)
from openrooms_usd.usd.rendersettings import asked_cameras, settings_losses

_LOG: Final = logging.getLogger("openrooms_usd")

# The part of the progress that exact channels take beside many samples.
_EXACT_SHARE: Final = 0.02
# Guides that no renderer gives are looked up at so many by so many places of a pixel.
_GUIDED_PLACES: Final = 2


def open_with(
    renderer: Renderer,
    stage: Usd.Stage,
    options: Mapping[str, str] = NO_OPTIONS,
    *,
    default_light: bool = True,
    texture_side: int | None = None,
) -> "OpenedStage":
    """Translate a stage, and let a renderer open what comes of it.

    Args:
        renderer: The renderer.
        stage: The composed stage. Any stage: ours, or one that follows none of our names.
        options: Values by the names that the renderer declares.
        default_light: Whether a stage without any light gets one.
        texture_side: The longest side of textures, pixels; None for what is affordable.

    Raises:
        InputError: The renderer has no such option, or an option no such value.
        RenderError: The renderer's backend is not available.
    """
    scene = translate(stage, default_light=default_light, texture_side=texture_side)
    return OpenedStage(stage, scene, renderer, options)


class OpenedStage:
    """A stage that is rendered from any of its cameras.

    Args:
        stage: The composed stage.
        scene: The same as arrays.
        renderer: What opens the scene.
        options: What is asked of the renderer.

    Attributes:
        session: What a renderer made of the scene.
        cameras: Prim paths of the stage's cameras, sorted.
        requested: Those of them that its render products name; none where nobody makes a choice.
        resolution: Width and height that the stage's render settings ask for.
        legend: What the label numbers mean.
        report: What became of every prim; rendering may add what became of a camera's picture.
    """

    def __init__(
        self, stage: Usd.Stage, scene: Scene, renderer: Renderer, options: Mapping[str, str]
    ) -> None:
        self.session: RenderSession = renderer.open(scene, options)
        if self.session.advice:
            _advise(self.session.advice)
        self._stage, self._moving = stage, MovingScene(scene)
        self._renderer, self._options = renderer, options
        self._channels = renderer.channels
        self._sources = sources_of(scene)
        cameras = list_cameras(stage)
        self.cameras = tuple(str(prim.GetPath()) for prim in cameras)
        self.requested = asked_cameras(stage)
        self.resolution = stage_resolution(stage)
        self.legend, self.report = scene.legend, scene.report
        for path, loss in settings_losses(stage):
            self.report.add(path, "approximated", loss)
        for prim in cameras:
            if loss := clipping_loss(prim):
                self.report.add(prim.GetPath(), "approximated", loss)

    @cached_property
    def lights(self) -> tuple[LightRecord, ...]:
        """The lights that channels of the scope ``light`` are given for, by their numbers."""
        return light_records(self._stage, self._scene, self._sources)

    def render(self, request: RenderRequest, progress: ViewProgress = lambda done: None) -> View:
        """Render one camera.

        Args:
            request: What to render.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: A channel or the camera does not exist, or the renderer cannot do it.
            StageError: The camera cannot make a picture.
        """
        _check(request, self._channels, self.session)
        return self.picture(self.camera(request), request, progress)

    def picture(
        self,
        camera: PinholeCamera,
        request: RenderRequest,
        progress: ViewProgress = lambda done: None,
    ) -> View:
        """Render what a camera sees that need not be one of the stage's.

        Args:
            camera: For the request's size.
            request: What to render; its camera is a name for random numbers and messages.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: A channel does not exist, or the renderer cannot do it.
        """
        _check(request, self._channels, self.session)
        progress(0.0)
        lit = tuple(name for name in request.channels if name in self._channels)
        exact = [name for name in request.channels if name not in lit]
        images: dict[str, Image] = {}
        if lit:
            share = 1.0 - _EXACT_SHARE if exact else 1.0
            asked = replace(request, channels=lit)
            images |= self.session.render(camera, asked, lambda done: progress(share * done))
        images |= self._exact(camera, request, exact)
        progress(1.0)
        wanted = each(request.channels, len(self._sources))
        if missing := [name for name in wanted if name not in images]:
            raise RenderError(
                f"the renderer gave nothing for the channel {missing[0]!r}",
                place=request.camera or "the framing camera",
            )
        return View(
            camera=request.camera,
            width=request.width,
            height=request.height,
            K=camera.K,
            world_from_camera=camera.world_from_camera,
            exposure=camera.exposure,
            projection=camera.projection,
            images={name: images[name] for name in wanted},
            guides=self.guides(camera, request) if request.guides else {},
        )

    def guides(
        self, camera: PinholeCamera, request: RenderRequest
    ) -> Mapping[str, NDArray[np.float32]]:
        """What a denoiser is guided by: means over whole pixels (`contract.GUIDES`).

        A pixel's centre sees one thread of a cloth or another by chance, and a denoiser takes that
        for what the picture shall look like.

        Args:
            camera: For the request's size.
            request: Its size.

        Returns:
            (height, width, 3) by channel.
        """
        if isinstance(self.session, GuidingSession):
            found = self.session.guides(camera, request)
            if found:
                return found
        n, height, width = _GUIDED_PLACES, request.height, request.width
        fine = replace(camera, K=np.diag([n, n, 1.0]) @ camera.K)
        asked = replace(request, channels=GUIDES, width=n * width, height=n * height, guides=False)
        images = self.picture(fine, asked).images
        return {
            name: images[name].pixels.reshape(height, n, width, n, -1).mean(axis=(1, 3))
            for name in GUIDES
        }

    def flow(
        self, camera: PinholeCamera, after: PinholeCamera, request: RenderRequest
    ) -> dict[str, Image]:
        """Where what a frame of a path sees is in the next frame (`openrooms_usd.channels.FLOWS`).

        Args:
            camera: Of the frame, for the request's size.
            after: Of the next frame, likewise.
            request: Its size.
        """
        start = time.perf_counter()
        tracer = self.session.tracer or self._caster
        made = optical_flow(self._scene, tracer, camera, after, (request.width, request.height))
        seconds = time.perf_counter() - start
        return {n: Image(pixels, 1, seconds, 0.0, robust_error=0.0) for n, pixels in made.items()}

    def move(self, motions: Mapping[str, Array]) -> None:
        """Render from now on what stands elsewhere; the stage is not translated again.

        A renderer that cannot follow opens the scene anew. `lights` stay as the stage has them.

        Args:
            motions: (4, 4) rigid by prim path, of the world to the world, metres, since the stage
                was opened; prims that are not named stay where they are.

        Raises:
            RenderError: The renderer's backend is not available.
        """
        if not self._moving.move(motions):
            return
        self.__dict__.pop("_caster", None)
        if isinstance(self.session, MovingSession):
            self.session.move(self._scene)
        else:
            self.session = self._renderer.open(self._scene, self._options)

    @property
    def caster(self) -> RayCaster:
        """Casts rays against what is rendered."""
        return self._caster.caster

    @property
    def _scene(self) -> Scene:
        return self._moving.scene

    def camera(self, request: RenderRequest) -> PinholeCamera:
        """The camera that a request names, for its size and with its lens.

        Raises:
            RenderError: There is no such camera.
            StageError: It cannot make a picture.
        """
        camera = self._described_camera(request)
        if camera.exposure is None:
            camera = replace(camera, exposure=self._scene.exposure)
        if request.f_stop is None:
            return camera
        if camera.projection != PINHOLE:
            raise RenderError(
                f"an {camera.projection} camera has no lens",
                place=request.camera,
                remedy="leave --f-stop away, or choose another --camera",
            )
        fov = 2.0 * math.degrees(math.atan(0.5 * request.width / camera.K[0, 0]))
        pose = camera.world_from_camera
        focus = camera.focus_distance or focus_distance(self.caster, pose[:3, 3], pose[:3, 2], fov)
        return with_lens(camera, request.f_stop, focus, request.width)

    def _described_camera(self, request: RenderRequest) -> PinholeCamera:
        if request.camera is None:
            if is_framed_here(self._scene):
                tracer = self.session.tracer or self._caster
                return framed(self._scene, tracer, request.width, request.height)
            return framing_camera(self._stage, request.width, request.height)
        if request.camera not in self.cameras:
            known = ", ".join(self.cameras) or "none; leave the camera away to frame the scene"
            raise RenderError("there is no such camera", place=request.camera, remedy=known)
        prim = self._stage.GetPrimAtPath(request.camera)
        return read_camera(prim, request.width, request.height)

    def _exact(
        self, camera: PinholeCamera, request: RenderRequest, channels: list[str]
    ) -> dict[str, Image]:
        """Channels of what the pixels' centres see; the ray that all share is in each's time."""
        if not channels:
            return {}
        start = time.perf_counter()
        tracer = self.session.tracer or self._caster
        hits = first_hits(self._scene, tracer, camera, request.width, request.height)
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
            images |= {
                single: Image(pixels, 1, seconds, 0.0, robust_error=0.0)
                for single, pixels in made.items()
            }
        return images

    @cached_property
    def _caster(self) -> CastingTracer:
        return CastingTracer(self._scene)


def _check(request: RenderRequest, own: tuple[str, ...], session: RenderSession) -> None:
    choose_method(request.method, session)
    for name in request.channels:
        if name not in own and name not in EXACT:
            raise RenderError(
                f"this renderer does not give the channel {name!r}", remedy=remedy_for(name)
            )
    if request.width < 1 or request.height < 1 or request.bounces < 0:
        raise RenderError(
            f"no picture has {request.width}x{request.height} pixels and {request.bounces} bounces",
            remedy="give a positive resolution and no negative number of bounces",
        )


@cache  # once a process, however many stages it opens
def _advise(advice: str) -> None:
    """Log what would make rendering faster or more complete on this machine."""
    _LOG.warning(advice)
