"""A stage that is open for a renderer: light is its part, all else the core's."""

import logging
from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pxr import Usd

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.channels import each
from openrooms_usd.description.rendering import Method, RenderSettings
from openrooms_usd.errors import RenderError
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.rendering import manifest
from openrooms_usd.rendering.channel_plan import ChannelPlan
from openrooms_usd.rendering.contract import (
    GuidingSession,
    Image,
    MovingSession,
    Renderer,
    RenderRequest,
    RenderSession,
    View,
    ViewProgress,
)
from openrooms_usd.rendering.exact import exact_images, fine_guides, flow_images
from openrooms_usd.rendering.friction import FRICTION, FrictionMap, read_materials
from openrooms_usd.rendering.given import check_request, choose_method
from openrooms_usd.rendering.lens import lens_of
from openrooms_usd.rendering.plan import paths_of
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.cameras import camera_losses
from openrooms_usd.rendering.scene.framing import framed, is_framed_here
from openrooms_usd.rendering.scene.light_records import light_records
from openrooms_usd.rendering.scene.lights import LightRecord
from openrooms_usd.rendering.scene.moving import MovingScene
from openrooms_usd.rendering.scene.rays import CastingTracer, RayTracer
from openrooms_usd.rendering.scene.sources import sources_of
from openrooms_usd.usd.cameras import (
    PinholeCamera,
    framing_camera,
    list_cameras,
    photograph,
    read_camera,
)
from openrooms_usd.usd.rendersettings import settings_losses, stage_resolution

if TYPE_CHECKING:
    from openrooms_usd.exporters import Report
    from openrooms_usd.rendering.scene.legend import Legend

_LOG: Final = logging.getLogger("openrooms_usd")

# The part of the progress that exact channels take beside many samples.
_EXACT_SHARE: Final = 0.02


class RenderContext:
    """A stage that is open for a renderer, as `openrooms_usd.rendering.opening` made it.

    Attributes:
        path: The USD file.
        stage: What it holds.
        settings: What is asked for.
        plan: Which channels are rendered, made and written.
        session: What the renderer made of the scene.
        cameras: Prim paths of the stage's cameras, sorted.
        views: Prim path by view name, in the order asked for; None for the framing camera.
        resolution: Width and height, pixels: of the settings, or else of the stage.
        legend: What the label numbers mean.
        report: What became of every prim; rendering may add what became of a camera's picture.
        method: How light is computed.
        translation: What opening it took, seconds.
    """

    views: Mapping[str, str | None]
    method: Method
    translation: float

    def __init__(
        self, path: Path, stage: Usd.Stage, scene: Scene, renderer: Renderer, plan: ChannelPlan
    ) -> None:
        self.path, self.stage, self.plan, self.settings = path, stage, plan, plan.settings
        self.session: RenderSession = renderer.open(scene, self.settings.options)
        if self.session.advice:
            _advise(self.session.advice)
        self._renderer, self._moving = renderer, MovingScene(scene)
        self._sources = sources_of(scene)
        cameras = list_cameras(stage)
        self.cameras = tuple(str(prim.GetPath()) for prim in cameras)
        size = self.settings.resolution or stage_resolution(stage)
        # What a stage says is checked as what a person says.
        self.resolution = self.settings.replace(resolution=size).resolution or size
        self.legend: Legend = scene.legend
        self.report: Report = scene.report
        seen = ((prim.GetPath(), loss) for prim in cameras for loss in camera_losses(prim, scene))
        for where, loss in (*settings_losses(stage), *seen):
            self.report.add(where, "approximated", loss)

    def with_settings(self, settings: RenderSettings) -> "RenderContext":
        """The same opened stage, with other settings for its pictures.

        What moves afterwards moves in neither of the two; those that concern the opening, such as
        the renderer, make no difference any more.

        Raises:
            InputError: A channel is unknown, or not to be had.
            MissingPackageError: The denoiser is asked for and not installed.
            RenderError: The session does not have the method that is asked for.
        """
        other = copy(self)
        other.settings = settings
        other.plan = ChannelPlan.of(settings, self._renderer, flow=self.plan.flow)
        other.resolution = settings.resolution or self.resolution
        other.method = other.choose_method()
        return other

    @property
    def scene(self) -> Scene:
        """What is rendered, as arrays: with everything where it stands now."""
        return self._moving.scene

    @property
    def tracer(self) -> RayTracer:
        """Finds the triangles that rays meet: the renderer's, or else the core's."""
        return self.session.tracer or self._caster

    @property
    def caster(self) -> RayCaster:
        """Casts rays against what is rendered."""
        return self._caster.caster

    @cached_property
    def lights(self) -> tuple[LightRecord, ...]:
        """The lights that channels of the scope ``light`` are given for, by their numbers."""
        return light_records(self.stage, self.scene, self._sources)

    @cached_property
    def friction(self) -> FrictionMap:
        """What tells friction of materials."""
        return FrictionMap(read_materials(self.stage, self.legend.material))

    def choose_method(self, paths: float | None = None, *, views: int | None = None) -> Method:
        """How light is computed: as asked for, or what takes less time.

        Args:
            paths: About how many paths are followed; None for those of all views.
            views: How many views these are; None for as many as there are.

        Raises:
            RenderError: The session does not have the method that is asked for.
        """
        if paths is None:
            paths = paths_of(self.request(method="reference"), views or len(self.views))
        return choose_method(self.settings.method, self.session, paths)

    def request(self, camera: str | None = None, **changes: Any) -> RenderRequest:
        """What the renderer and the core are asked for, by the settings.

        Args:
            camera: A prim path, or what sets random numbers apart from those of other pictures.
            **changes: Other values, by the fields of the request.
        """
        settings = self.settings
        width, height = self.resolution
        usual: dict[str, Any] = {
            "channels": self.plan.rendered,
            "width": width,
            "height": height,
            "samples": settings.samples_or_default,
            "error": settings.error,
            "seconds": settings.seconds,
            "seed": settings.seed,
            "bounces": settings.bounces,
            "grid": settings.grid,
            "guides": self.plan.denoiser is not None,
            "halves": self.plan.halves,
        }
        if "method" not in changes:
            usual["method"] = self.method
        return RenderRequest(camera, **(usual | changes))

    @property
    def listed(self) -> RenderRequest:
        """What files of the views list: the channels that they have in the end."""
        return self.request(channels=self.plan.written)

    def entry(self, request: RenderRequest | None = None) -> dict[str, Any]:
        """What the manifest says of all views.

        Args:
            request: What they were asked for, and which channels are listed; by default `listed`.
        """
        asked = request or self.listed
        shared = self.path, self.settings, self.session, asked, self.lights, self.legend
        made = {"denoiser": self.plan.denoiser, "friction": self._friction}
        told = {name: one.entry() for name, one in made.items() if one is not None}
        return manifest.run_entry(*shared) | told

    def photograph(self, name: str) -> Mapping[str, str] | None:
        """What a view stands for in a capture, if anything."""
        camera = self.views[name]
        return photograph(self.stage.GetPrimAtPath(camera)) if camera else None

    def view(self, name: str, progress: ViewProgress = lambda done: None) -> View:
        """One of `views`, with all that is asked for.

        Args:
            name: The view's name.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: The renderer cannot do it.
            StageError: The camera cannot make a picture.
        """
        path = self.views[name]
        return self.shoot(self.camera(path), path, progress)

    def shoot(
        self,
        camera: PinholeCamera,
        name: str | None,
        progress: ViewProgress = lambda done: None,
        *,
        size: tuple[int, int] | None = None,
        after: PinholeCamera | None = None,
    ) -> View:
        """What any camera sees, with all that is asked for.

        Args:
            camera: For the size.
            name: Sets its random numbers apart from those of others; a prim path where it has one.
            progress: Called with the finished fraction, from 0 to 1.
            size: Width and height, pixels; by default `resolution`.
            after: The next camera of a path, where flow is asked for.

        Raises:
            RenderError: The renderer cannot do it.
        """
        width, height = size or self.resolution
        asked = self.request(name, width=width, height=height)
        view = self.picture(camera, asked, progress)
        view = self.plan.complete(view, len(self._sources), self._friction)
        if not self.plan.flow or after is None:
            return view
        flow = flow_images(self.scene, self.tracer, camera, after, (width, height))
        return replace(view, images={**view.images, **flow})

    def render(self, request: RenderRequest, progress: ViewProgress = lambda done: None) -> View:
        """What a camera of the stage sees: the channels of a request, and nothing made of them.

        Raises:
            RenderError: A channel or the camera does not exist, or the renderer cannot do it.
            StageError: The camera cannot make a picture.
        """
        camera = self.camera(request.camera, (request.width, request.height))
        return self.picture(camera, request, progress)

    def picture(
        self,
        camera: PinholeCamera,
        request: RenderRequest,
        progress: ViewProgress = lambda done: None,
    ) -> View:
        """What any camera sees: the channels of a request, and nothing made of them.

        Args:
            camera: For the request's size.
            request: What to render; its camera is a name for random numbers and messages.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: A channel does not exist, or the renderer cannot do it.
        """
        own = self._renderer.channels
        check_request(request, own, self.session)
        progress(0.0)
        lit = tuple(name for name in request.channels if name in own)
        exact = [name for name in request.channels if name not in lit]
        images: dict[str, Image] = {}
        if lit:
            share = 1.0 - _EXACT_SHARE if exact else 1.0
            asked = replace(request, channels=lit)
            images |= self.session.render(camera, asked, lambda done: progress(share * done))
        size = request.width, request.height
        images |= exact_images(self.scene, self.tracer, self._sources, camera, size, exact)
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

    def guides(self, camera: PinholeCamera, request: RenderRequest) -> Mapping[str, Floats]:
        """What a denoiser is guided by: means over whole pixels (`contract.GUIDES`).

        Args:
            camera: For the request's size.
            request: Its size.

        Returns:
            (height, width, 3) by channel.
        """
        session = self.session
        found = session.guides(camera, request) if isinstance(session, GuidingSession) else {}
        return found or fine_guides(self.picture, camera, request)

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
            self.session.move(self.scene)
        else:
            self.session = self._renderer.open(self.scene, self.settings.options)

    def camera(self, path: str | None, size: tuple[int, int] | None = None) -> PinholeCamera:
        """A camera of the stage, with the lens that is asked for.

        Args:
            path: Its prim path; None for one that frames the scene.
            size: Width and height, pixels; by default `resolution`.

        Raises:
            RenderError: There is no such camera.
            StageError: It cannot make a picture.
        """
        size = size or self.resolution
        camera = self._described_camera(path, *size)
        return self.prepared(camera, size[0], path)

    def prepared(
        self, camera: PinholeCamera, width: int, place: str | None = None
    ) -> PinholeCamera:
        """A camera with the scene's exposure, and the lens that is asked for.

        Raises:
            RenderError: It is not a camera with a lens.
        """
        if camera.exposure is None:
            camera = replace(camera, exposure=self.scene.exposure)
        if self.settings.f_stop is None:
            return camera
        return lens_of(camera, self.settings.f_stop, self.caster, width, place)

    def _described_camera(self, path: str | None, width: int, height: int) -> PinholeCamera:
        if path is None:
            if is_framed_here(self.scene):
                return framed(self.scene, self.tracer, width, height)
            return framing_camera(self.stage, width, height)
        if path not in self.cameras:
            known = ", ".join(self.cameras) or "none; without --camera the scene is framed"
            raise RenderError("there is no such camera", place=path, remedy=known)
        return read_camera(self.stage.GetPrimAtPath(path), width, height)

    @property
    def _friction(self) -> FrictionMap | None:
        return self.friction if FRICTION in self.plan.asked else None

    @cached_property
    def _caster(self) -> CastingTracer:
        return CastingTracer(self.scene)


@cache  # once a process, however many stages it opens
def _advise(advice: str) -> None:
    """Log what would make rendering faster or more complete on this machine."""
    _LOG.warning(advice)
