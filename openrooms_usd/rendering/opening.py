"""The one way from a stage to its pictures: whatever draws a stage opens it here."""

import time
from collections.abc import Sequence
from pathlib import Path

from pxr import Usd

from openrooms_usd import adapters
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.exporters import add_composition_errors
from openrooms_usd.rendering.channel_plan import ChannelPlan
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.contract import Renderer
from openrooms_usd.rendering.plan import choose_cameras
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.cameras import set_field_of_view
from openrooms_usd.usd.files.diagnostics import reading
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.moments import freeze_time
from openrooms_usd.usd.rendersettings import asked_cameras
from openrooms_usd.usd.shading.mtlxlayers import read_mtlx_layers


def load_renderer(settings: RenderSettings) -> Renderer:
    """The renderer that is asked for, which has the options that are asked of it.

    Raises:
        InputError: There is no such renderer, or it has no such option.
        MissingPackageError: It needs a package that is not installed.
    """
    renderer: Renderer = adapters.load(adapters.RENDERERS, settings.renderer)
    adapters.check_options(
        adapters.RENDERERS, settings.renderer, renderer.options, settings.options
    )
    return renderer


def check_settings(settings: RenderSettings, *, flow: bool = False) -> ChannelPlan:
    """Refuse what cannot work before anything slow begins.

    Raises:
        InputError: A renderer, an option or a channel is unknown, or not to be had.
        MissingPackageError: The renderer or the denoiser needs a package that is not installed.
    """
    return ChannelPlan.of(settings, load_renderer(settings), flow=flow)


def open_for_rendering(
    stage: Path | Usd.Stage,
    settings: RenderSettings | None = None,
    *,
    cameras: Sequence[str] = (),
    views: int | None = None,
    spares: bool = False,
    flow: bool = False,
    renderer: Renderer | None = None,
) -> RenderContext:
    """Open a stage for a renderer, with all that it needs before it is drawn.

    MaterialX files become materials, what moves is held at one time, skins are posed, fields of
    view set, a default light added and textures made smaller, as the settings say. The report tells
    what became of each prim.

    Args:
        stage: A USD file, or a stage that is open: ours, or one that follows none of our names. Its
            files stay as they are.
        settings: What is asked for.
        cameras: Names or prim paths of the views; where empty those that the stage's render
            products name, else all cameras but spare ones, and a framing camera where the stage has
            none.
        views: For how many views a method is chosen; by default as many as there are.
        spares: Whether cameras that a room keeps in case are views too.
        flow: Whether views are frames of a path, which have the optical flow to the next one.
        renderer: One that need not be registered, in place of the settings' own.

    Raises:
        InputError: The stage is unreadable, a camera or a channel is unknown, or the renderer has
            no such option.
        MissingPackageError: The renderer or the denoiser needs a package that is not installed.
        RenderError: The renderer's backend is not available.
    """
    settings = settings or RenderSettings()
    adapter = renderer or load_renderer(settings)
    # Refused before anything slow.
    plan = ChannelPlan.of(settings, adapter, flow=flow)
    opened = open_stage(stage) if isinstance(stage, Path) else stage
    path = stage if isinstance(stage, Path) else Path(opened.GetRootLayer().GetDisplayName())
    began = time.perf_counter()
    with reading(path):
        read_mtlx_layers(opened)
        lost = freeze_time(opened, settings.time_code)
        if settings.field_of_view is not None:
            set_field_of_view(opened, settings.field_of_view)
        scene = translate(
            opened, default_light=settings.default_light, texture_side=settings.texture_side
        )
        context = RenderContext(path, opened, scene, adapter, plan)
        context.report.lose(lost)
        add_composition_errors(context.report, opened)
    context.translation = time.perf_counter() - began
    asked = cameras or asked_cameras(opened)
    context.views = choose_cameras(asked, context.cameras, spares=spares)
    context.method = context.choose_method(views=views)
    return context
