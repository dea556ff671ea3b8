"""A render job: what is asked of all views of a stage, refused early, and opened once for them.

Who writes the views decides where they go: a run writes them into one folder (`driver`), a dataset
one by one.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from openrooms_usd import adapters
from openrooms_usd.channels import FLOWS, each
from openrooms_usd.convert import Report, conclude
from openrooms_usd.render import manifest
from openrooms_usd.render.contract import (
    COMPLETE,
    DEFAULT_BOUNCES,
    DEFAULT_GRID,
    NO_OPTIONS,
    PHOTOGRAPH,
    Method,
    Renderer,
    RenderRequest,
    View,
    ViewProgress,
)
from openrooms_usd.render.denoise import DENOISED, Denoiser, load_denoiser
from openrooms_usd.render.denoised_light import Denoise, with_denoised_light
from openrooms_usd.render.friction import FRICTION, FrictionMap, read_materials
from openrooms_usd.render.given import available, check_method, choose_method
from openrooms_usd.render.plan import (
    check_texture_side,
    check_time_code,
    choose_cameras,
    choose_channels,
    paths_of,
    plan,
    sized,
)
from openrooms_usd.render.scene.lights import LightRecord
from openrooms_usd.render.shading import Shading

if TYPE_CHECKING:
    from pxr import Usd

    from openrooms_usd.render.opened import OpenedStage
    from openrooms_usd.usd.cameras import PinholeCamera


@dataclass(frozen=True, eq=False)
class RenderJob:
    """What is asked of all views, checked as far as it can be without the stage.

    Attributes:
        renderer: The name under which the renderer is registered.
        adapter: The renderer.
        options: What is asked of it.
        request: What every view is asked for, still without a camera.
        method: The method that is asked for; None for what takes less time.
        resolution: Width and height in pixels; None for what the stage says.
        field_of_view: Horizontal, degrees, of all cameras; None for what each has.
        error_maps: Whether views have the estimated errors of pixels.
        denoise: Which versions are denoised.
        denoiser: What does it.
        flow: Whether views are frames of a path, which have the optical flow to the next one.
        time_code: When a stage that moves is seen; None for the first sample of everything.
        default_light: Whether a stage without any light gets one.
        texture_side: The longest side of textures, pixels; None for what is affordable.
    """

    renderer: str
    adapter: Renderer
    options: Mapping[str, str]
    request: RenderRequest
    method: Method | None = None
    resolution: tuple[int, int] | None = None
    field_of_view: float | None = None
    error_maps: bool = False
    denoise: Denoise = False
    denoiser: Denoiser | None = None
    flow: bool = False
    time_code: float | None = None
    default_light: bool = True
    texture_side: int | None = None

    @classmethod
    def of(
        cls,
        *,
        channels: Sequence[str] | None = None,
        resolution: tuple[int, int] | None = None,
        field_of_view: float | None = None,
        grid: tuple[int, int] = DEFAULT_GRID,
        error_maps: bool = False,
        samples: int | None = None,
        error: float | None = None,
        seconds: float | None = None,
        seed: int = 0,
        bounces: int = DEFAULT_BOUNCES,
        method: str | None = None,
        tone: str = PHOTOGRAPH,
        f_stop: float | None = None,
        storage: str = COMPLETE,
        renderer: str = "mitsuba",
        options: Mapping[str, str] = NO_OPTIONS,
        denoise: Denoise = False,
        flow: bool = False,
        time_code: float | None = None,
        default_light: bool = True,
        texture_side: int | None = None,
    ) -> "RenderJob":
        """The job of these wishes, which are those of `openrooms_usd.render.driver.render_stage`.

        ``flow`` asks for the optical flow of views that are the frames of a path.

        Raises:
            InputError: A name is unknown, a number is absurd, or nobody gives a channel with this
                renderer.
            MissingPackageError: The denoiser is asked for and not installed.
        """
        adapter: Renderer = adapters.load(adapters.RENDERERS, renderer)
        adapters.check_options(adapters.RENDERERS, renderer, adapter.options, options)
        request = plan(
            choose_channels(channels, available(adapter.channels)),
            resolution,
            samples=samples,
            error=error,
            seconds=seconds,
            seed=seed,
            bounces=bounces,
            grid=grid,
            tone=tone,
            f_stop=f_stop,
            storage=storage,
        )
        named = check_method(method)
        denoiser = load_denoiser() if denoise else None
        if denoiser:
            denoiser.check(request.channels)
        return cls(
            renderer, adapter, options, request, named, resolution, field_of_view, error_maps,
            denoise, denoiser, flow, None if time_code is None else check_time_code(time_code),
            default_light, None if texture_side is None else check_texture_side(texture_side),
        )  # fmt: skip

    @cached_property
    def shading(self) -> Shading:
        """What makes channels of shading of others."""
        return Shading(self.adapter.channels)

    @cached_property
    def shaded(self) -> tuple[str, ...]:
        """The channels of a view once shading is made: all that is asked for or friction needs."""
        asked = self.request.channels
        return FrictionMap.needs(asked) if FRICTION in asked else asked

    @property
    def written(self) -> tuple[str, ...]:
        """The channels that views have in the end."""
        asked = self.request.channels
        return (*asked, *(FLOWS if self.flow else ()), *((DENOISED,) if self.denoiser else ()))

    @property
    def rendered(self) -> RenderRequest:
        """What the renderer and the core are asked for."""
        asked, shades = self.shaded, self.shading.makes(self.request.channels)
        return replace(
            self.request,
            channels=self.shading.needs(asked) if shades else asked,
            guides=self.denoiser is not None,
            # Errors of what is made of others are told by making it twice.
            halves=self.error_maps or shades or self.denoise == "all",
        )

    def open(
        self, path: Path, cameras: Sequence[str] = (), *, views: int | None = None
    ) -> "OpenedJob":
        """Translate a stage, and let the renderer open it.

        Args:
            path: The USD file.
            cameras: Names or prim paths; where empty those that the stage's render products name,
                else all cameras, and a framing camera where the stage has none.
            views: For how many views a method is chosen; by default as many as are rendered.

        Raises:
            InputError: The stage is unreadable, or a camera is unknown.
            RenderError: The renderer cannot do it.
        """
        from openrooms_usd.render.opened import open_with
        from openrooms_usd.usd.cameras import set_field_of_view
        from openrooms_usd.usd.diagnostics import reading
        from openrooms_usd.usd.layers import open_stage
        from openrooms_usd.usd.moments import hold
        from openrooms_usd.usd.mtlxlayers import read_mtlx_layers

        stage = open_stage(path)
        began = time.perf_counter()
        with reading(path):
            read_mtlx_layers(stage)
            lost = hold(stage, self.time_code)
            if self.field_of_view is not None:
                set_field_of_view(stage, self.field_of_view)
            opened = open_with(
                self.adapter,
                stage,
                self.options,
                default_light=self.default_light,
                texture_side=self.texture_side,
            )
            opened.report.lose(lost)
            conclude(opened.report, stage)
        took = time.perf_counter() - began
        request = sized(self.rendered, self.resolution or opened.resolution)
        chosen = choose_cameras(cameras or opened.requested, opened.cameras)
        paths = paths_of(request, views or len(chosen))
        request = replace(request, method=choose_method(self.method, opened.session, paths))
        return OpenedJob(self, path, stage, opened, request, chosen, took)


@dataclass(frozen=True, eq=False)
class OpenedJob:
    """A stage that is opened for a job.

    Attributes:
        job: What is asked.
        path: The USD file.
        stage: What it holds.
        opened: The same, translated and opened by the renderer.
        request: What the renderer and the core are asked for, with its size and method.
        views: Prim path by view name; None for the framing camera.
        translation: What opening it took, seconds.
    """

    job: RenderJob
    path: Path
    stage: "Usd.Stage"
    opened: "OpenedStage"
    request: RenderRequest
    views: Mapping[str, str | None]
    translation: float

    @property
    def listed(self) -> RenderRequest:
        """What files of the views list: the channels that they have in the end."""
        return replace(self.request, channels=self.job.written)

    @property
    def lights(self) -> tuple[LightRecord, ...]:
        """Those of the scene, by their numbers."""
        return self.opened.lights

    @property
    def report(self) -> Report:
        """What became of every prim so far."""
        return self.opened.report

    @cached_property
    def friction(self) -> FrictionMap | None:
        """What tells friction of materials, where that is asked for."""
        if FRICTION not in self.job.request.channels:
            return None
        return FrictionMap(read_materials(self.stage, self.opened.legend.material))

    def entry(self) -> dict[str, Any]:
        """What the manifest says of all views."""
        job = self.job
        entry = manifest.run_entry(
            self.path, job.renderer, self.opened, self.listed, time_code=job.time_code
        )
        if self.job.denoiser:
            entry["denoiser"] = self.job.denoiser.entry()
        return entry | ({"friction": self.friction.entry()} if self.friction else {})

    def photograph(self, name: str) -> Mapping[str, str] | None:
        """What a view stands for in a capture, if anything."""
        from openrooms_usd.usd.cameras import photograph

        camera = self.views[name]
        return photograph(self.stage.GetPrimAtPath(camera)) if camera else None

    def render(self, name: str, progress: ViewProgress = lambda done: None) -> View:
        """One view with all that is asked for.

        Args:
            name: One of `views`.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: The renderer cannot do it.
        """
        asked = replace(self.request, camera=self.views[name])
        return self._completed(self.opened.render(asked, progress))

    def camera(self, name: str) -> "PinholeCamera":
        """The camera of one of `views`, for the job's size.

        Raises:
            StageError: It cannot make a picture.
        """
        return self.opened.camera(replace(self.request, camera=self.views[name]))

    def shoot(
        self,
        camera: "PinholeCamera",
        name: str | None,
        progress: ViewProgress = lambda done: None,
        after: "PinholeCamera | None" = None,
    ) -> View:
        """What any camera sees, with all that is asked for.

        Args:
            camera: For the job's size.
            name: Sets its random numbers apart from those of others; a prim path where it has one.
            progress: Called with the finished fraction, from 0 to 1.
            after: The next camera of a path, where flow is asked for.

        Raises:
            RenderError: The renderer cannot do it.
        """
        asked = replace(self.request, camera=name)
        view = self._completed(self.opened.picture(camera, asked, progress))
        if not self.job.flow or after is None:
            return view
        return replace(view, images={**view.images, **self.opened.flow(camera, after, asked)})

    def _completed(self, view: View) -> View:
        """A view with what is made of what was rendered."""
        job, lights = self.job, len(self.lights)
        if job.shading.makes(job.request.channels):
            view = job.shading.complete(view, each(job.shaded, lights))
        if self.friction:
            view = self.friction.complete(view, each(job.request.channels, lights))
        if job.denoiser:
            clean = with_denoised_light(view, job.denoiser).denoised if job.denoise == "all" else {}
            view = replace(job.denoiser.complete(view), denoised=clean)
        return view if job.error_maps else _without_halves(view)


def _without_halves(view: View) -> View:
    images = {name: replace(image, halves=None) for name, image in view.images.items()}
    return replace(view, images=images)
