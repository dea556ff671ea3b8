"""A scene that Mitsuba has opened: its cameras are rendered into channels of light."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, Final

import drjit as dr
import mitsuba as mi

from openrooms_usd.arrays import Floats
from openrooms_usd.channels import CHANNELS
from openrooms_usd.rendering import Image, RenderRequest
from openrooms_usd.rendering.bake.request import Irradiance, IrradianceRequest
from openrooms_usd.rendering.contract import CACHE, GUIDES, REFERENCE, Method, ViewProgress
from openrooms_usd.rendering.probes import ProbeRequest
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.models import report_principled, report_simplified, with_model
from openrooms_usd.rendering.scene.sources import sources_of
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.bias import measurable, with_bias
from orusd_mitsuba.cache.room_light import LEAST_BOUNCES, RoomLight
from orusd_mitsuba.complete.channels import RECEIVED
from orusd_mitsuba.complete.denoiser_guides import SAMPLES as GUIDE_SAMPLES
from orusd_mitsuba.complete.denoiser_guides import GuideIntegrator
from orusd_mitsuba.complete.integrator import CompleteIntegrator, RequestedOutputs
from orusd_mitsuba.complete.meeting import CompleteScene
from orusd_mitsuba.complete.smoothed import SMOOTHED
from orusd_mitsuba.direct.integrator import DirectIntegrator
from orusd_mitsuba.limits import (
    affordable_model,
    check_channels,
    check_vectorized,
    instances_advice,
    report_panes,
)
from orusd_mitsuba.pictures import Changes
from orusd_mitsuba.plugins.build import Builder
from orusd_mitsuba.render_passes import (
    COMPLETE,
    DIRECT,
    ENVIRONMENT,
    RenderPass,
    passes_for,
    run_pass,
)
from orusd_mitsuba.tracer import MitsubaTracer
from orusd_mitsuba.transport.builtin_integrator import BuiltinIntegrator
from orusd_mitsuba.transport.hemispheres import HemisphereIntegrator, coarse
from orusd_mitsuba.transport.integrator import Integrator, SparseIntegrator
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.panes import Panes
from orusd_mitsuba.transport.path_integrator import PathIntegrator
from orusd_mitsuba.transport.paths import Paths, TracedPaths
from orusd_mitsuba.transport.probes import render_probes
from orusd_mitsuba.transport.sampling import ProgressiveSampler
from orusd_mitsuba.transport.scattered import ScatteredLight
from orusd_mitsuba.transport.texels import light_texels
from orusd_mitsuba.transport.white import white_first
from orusd_mitsuba.variants import Backend

_CONVENTIONS: Final = {
    "bsdf": "how surfaces reflect: auto, as each material says; openrooms, all by the microfacet "
    "model of OpenRooms; preview, all as UsdPreviewSurface"
}

# Guides depend on no request: they hardly have noise.
_GUIDE_SEED: Final = 0x6D6F6972


class MitsubaSession:
    """A scene that is built once and rendered by any camera.

    Args:
        scene: The translated stage.
        backend: What `orusd_mitsuba.variants.choose` found.
        bsdf: How surfaces shall reflect, one of `openrooms_usd.rendering.scene.models.MODELS`.

    Attributes:
        backend: What computes, for the record.
        is_vectorized: Whether the backend computes many samples at a time; a scalar one calls
            Mitsuba's own integrator for the radiance, and nothing else.
        advice: What would make it faster or more complete; empty when nothing would.
        settings: How surfaces reflect, which may be less than was asked for: the report says so.
        conventions: What that means.
        methods: What there is of them; backends that do not compute in vectors have one.
        tracer: Finds triangles by Mitsuba's own ray tracer.

    Raises:
        InputError: No reflectance model has that name.
        RenderError: Its instances do not fit into memory.
    """

    def __init__(self, scene: Scene, backend: Backend, bsdf: str = "auto") -> None:
        self._variant = backend.variant
        self._activate()
        model = affordable_model(bsdf, backend)
        self._scene = with_model(scene, model)
        self.is_vectorized = not backend.variant.startswith("scalar")
        if not self.is_vectorized:
            report_panes(self._scene)
            report_simplified(self._scene)
            report_principled(self._scene)
        # Before they are built: they may not fit.
        crowded = instances_advice(self._scene) if self.is_vectorized else ""
        self._builder = Builder(self._scene.origin)
        self._built = self._builder.scene(self._scene)
        self._sources = sources_of(self._scene)
        starts = self._builder.first_rows(self._scene)
        self.tracer = MitsubaTracer(self._scene, self._built, starts)
        self.backend = f"mitsuba {mi.__version__} {backend.variant}"
        self.advice = backend.advice or crowded
        self.methods: tuple[Method, ...] = (REFERENCE, *((CACHE,) if self.is_vectorized else ()))
        self._room_lights: dict[int, RoomLight] = {}
        self.settings: Mapping[str, str] = {"bsdf": model}
        self.conventions: Mapping[str, str] = _CONVENTIONS

    def render(
        self,
        camera: PinholeCamera,
        request: RenderRequest,
        progress: ViewProgress = lambda fraction: None,
    ) -> dict[str, Image]:
        """Render one camera: each render pass that is needed, in equal parts of the time.

        Args:
            camera: What sees the scene.
            request: What to render.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: The backend cannot give a channel.
        """
        self._activate()
        check_channels(request, self._variant)
        needed = passes_for(request.channels)
        if request.method == CACHE or any(one is DIRECT for one, _ in needed):
            # Before the first pass: a new kind of surface changes the code of all kernels.
            _ = self._white
        guided = request.guides and self.is_vectorized
        if guided or any(one is COMPLETE for one, _ in needed):
            _ = self._complete
        _give_back()
        seconds = None if request.seconds is None else request.seconds / len(needed)
        part = replace(request, seconds=seconds)
        images: dict[str, Image] = {}
        for number, (render_pass, found) in enumerate(needed):
            integrator = self._integrator(render_pass, camera, request, found)
            share = partial(_share, progress, number, len(needed))
            given, changes, sampler = run_pass(
                render_pass, integrator, part, found, len(self._sources), share
            )
            images |= self._measured(
                given, changes, render_pass, integrator, camera, request, found
            )
            self._note(request, render_pass.name, sampler, int(integrator.broken.sum()))
            _give_back()
        return images

    def guides(self, camera: PinholeCamera, request: RenderRequest) -> Mapping[str, Floats]:
        """What a denoiser is guided by; see the core's `GuidingSession`.

        Args:
            camera: What sees the scene.
            request: Its size.
        """
        self._activate()
        if not self.is_vectorized:
            return {}
        size = request.width, request.height
        planes = GuideIntegrator(self._complete, camera, *size)(GUIDE_SAMPLES, _GUIDE_SEED)
        _give_back()
        return dict(zip(GUIDES, planes, strict=True))

    def move(self, scene: Scene) -> None:
        """Render from now on what stands elsewhere; see the core's `MovingSession`.

        Lights are sampled as often as before: a rigid motion changes no flux.

        Args:
            scene: The scene that was opened, but for where triangles are.
        """
        self._activate()
        stand = [patch.triangles for patch in (*scene.patches, *scene.panes)]
        moved = self._scene.placed(stand)
        self._builder.move(self._built, self._scene, moved)
        self._scene = moved
        self._room_lights.clear()
        for made in ("_complete", *(("_index", "_glazed") if scene.panes else ())):
            self.__dict__.pop(made, None)

    def probe(
        self, request: ProbeRequest, progress: ViewProgress = lambda fraction: None
    ) -> tuple[Image, ...]:
        """Render the panoramas about points.

        Args:
            request: Where, and how.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: The backend cannot.
        """
        self._activate()
        check_vectorized(self._variant, "make light probes")
        return render_probes(self._built, self._index, self._scene.origin, request, progress)

    def irradiance(
        self, request: IrradianceRequest, progress: ViewProgress = lambda fraction: None
    ) -> Irradiance:
        """The irradiance of every light at texels of lightmaps.

        Args:
            request: Where, and how.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: The backend cannot.
        """
        self._activate()
        check_vectorized(self._variant, "make lightmaps")
        light = self._room_light(request.method, request.bounces)
        paths: Paths = (
            light.paths(by_light=True)
            if light
            else TracedPaths(self._built, self._index, request.bounces + 1)
        )
        return light_texels(
            paths, self._index.count, self._white, self._scene.origin, request, progress
        )

    def _activate(self) -> None:
        # Variants are chosen for the whole thread; another session may have changed it.
        mi.set_variant(self._variant)
        mi.set_log_level(mi.LogLevel.Error)

    def _measured(
        self,
        images: Mapping[str, Image],
        changes: Changes,
        render_pass: RenderPass,
        integrator: Integrator,
        camera: PinholeCamera,
        request: RenderRequest,
        channels: tuple[str, ...],
    ) -> Mapping[str, Image]:
        """The images of a pass, with what they are off where the method is not the reference."""
        wanted = measurable(channels)
        if request.method == REFERENCE or not (wanted and request.measure_bias):
            return images
        alike = replace(request, method=REFERENCE)
        reference = self._integrator(render_pass, camera, alike, channels)
        assert isinstance(integrator, SparseIntegrator) and isinstance(reference, SparseIntegrator)
        return with_bias(
            images, changes, render_pass, integrator, reference, request, wanted, len(self._sources)
        )

    def _integrator(
        self,
        render_pass: RenderPass,
        camera: PinholeCamera,
        request: RenderRequest,
        channels: tuple[str, ...],
    ) -> Integrator:
        size = request.width, request.height
        if not self.is_vectorized:
            origin, panes = self._scene.origin, bool(self._scene.panes)
            return BuiltinIntegrator(self._glazed, camera, request, origin, panes=panes)
        if render_pass is DIRECT:
            return DirectIntegrator(
                self._scene, self._built, self._sources, self._index, self._white, camera, *size
            )
        light = self._room_light(request.method, request.bounces)
        if render_pass is ENVIRONMENT:
            seen = replace(camera, K=coarse(camera, size, request.grid))
            return HemisphereIntegrator(
                self._scene,
                self._built,
                self._index,
                self.tracer,
                seen,
                request.grid,
                request.bounces + 1,
                arrival=light.arriving() if light else None,
            )
        depth = request.bounces + 1
        by_light = any(CHANNELS[name].scope == "light" for name in channels)
        if render_pass is COMPLETE:
            paths: Paths = (
                light.paths(by_light=by_light)
                if light
                else TracedPaths(self._built, self._index, depth)
            )
            scattered = ScatteredLight(paths, is_cheap=light is not None)
            wanted = RequestedOutputs(
                by_light=by_light,
                rest=not RECEIVED.issuperset(channels),
                unoccluded=not {"unoccluded_i", "visibility_i"}.isdisjoint(channels),
                guides=light is not None and not SMOOTHED.isdisjoint(channels),
            )
            return CompleteIntegrator(
                self._complete, scattered, camera, *size, depth, wanted, paths
            )
        return PathIntegrator(
            self._built,
            self._index,
            camera,
            *size,
            self._scene.origin,
            depth,
            by_light=by_light,
            paths=light.paths(by_light=by_light) if light else None,
        )

    def _room_light(self, method: Method, bounces: int) -> RoomLight | None:
        """The cache that light is looked up in, if the method does that."""
        if method != CACHE or bounces < LEAST_BOUNCES:
            return None
        if self._builder.table is None or self._index.is_linked:
            return None
        if bounces not in self._room_lights:
            self._room_lights[bounces] = RoomLight(
                self._scene, self._built, self._builder, self._index, self._white, bounces
            )
        return self._room_lights[bounces]

    @cached_property
    def _glazed(self) -> Any:
        """The scene with its panes among its shapes, for Mitsuba's own integrator."""
        if not self._scene.panes:
            return self._built
        return Builder(self._scene.origin).scene(self._scene, panes=True)

    @cached_property
    def _index(self) -> LightIndex:
        panes = Panes(self._scene) if self._scene.panes else None
        origin, patches = self._scene.origin, self._scene.patches
        return LightIndex(self._sources, self._built, origin, panes, patches)

    @cached_property
    def _complete(self) -> CompleteScene:
        return CompleteScene(self._scene, self._built, self._builder, self._sources, self._index)

    @cached_property
    def _white(self) -> Callable[[Any], Any]:
        return white_first(self._scene, self._built, self._builder)

    def _note(
        self, request: RenderRequest, what: str, sampler: ProgressiveSampler, replaced: int
    ) -> None:
        where = request.camera or "framing camera"
        if request.error is not None and (sampler.error or 0.0) > request.error:
            reason = (
                f"{what}: estimated error {sampler.error:.2g} after {sum(sampler.samples)} samples "
                f"a pixel, not {request.error:g}"
            )
            self._scene.report.add(where, "approximated", reason)
        if replaced:
            reason = f"{what} was not finite in {replaced} pixels; 0 is used"
            self._scene.report.add(where, "approximated", reason)


def _give_back() -> None:
    """Give memory back that Dr.Jit keeps for reuse: each step takes pieces of other sizes."""
    dr.flush_malloc_cache()


def _share(progress: ViewProgress, number: int, count: int, done: float) -> None:
    """The progress of one render pass as that of all."""
    progress((number + done) / count)
