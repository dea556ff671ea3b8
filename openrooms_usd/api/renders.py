"""Pictures with ground truth, and rooms beside their photographs."""

import logging
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Final, Literal

from openrooms_usd.api.given import AnyPath, names_of, path_of, size_of, usd_file
from openrooms_usd.api.rendered import Render, read_render
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from openrooms_usd.comparison.driver import Comparison

_LOG: Final = logging.getLogger("openrooms_usd")
_RENDER: Final = "render"


def render(
    scene: AnyPath,
    out: AnyPath | None = None,
    *,
    cameras: str | Sequence[str] = (),
    channels: str | Iterable[str] | None = None,
    resolution: tuple[int, int] | None = None,
    field_of_view: float | None = None,
    samples: int | None = None,
    error: float | None = None,
    seconds: float | None = None,
    seed: int = 0,
    bounces: int | None = None,
    method: str | None = None,
    tone: str = "photograph",
    f_stop: float | None = None,
    storage: str = "complete",
    grid: tuple[int, int] | None = None,
    error_maps: bool = False,
    denoise: bool | Literal["all"] = False,
    time_code: float | None = None,
    default_light: bool = True,
    texture_side: int | None = None,
    renderer: str = "mitsuba",
    options: Mapping[str, str] | None = None,
    progress: Progress = silent,
) -> Render:
    """Render the cameras of a scene with their ground truth.

    Args:
        scene: A composed room or any USD file.
        out: The folder to write; by default ``render`` beside the scene.
        cameras: Names or prim paths; all cameras by default.
        channels: Names such as ``depth`` (docs/channels.md), ``all`` or ``usual``, the default.
        resolution: Width and height in pixels; by default what the scene says.
        field_of_view: Horizontal, degrees, of all cameras; by default what each has.
        samples: Samples a pixel; 64 by default where neither ``error`` nor ``seconds`` is given.
        error: Stop a view at this estimated robust error of its radiance.
        seconds: Stop a view after about this time.
        seed: Fixes every random number.
        bounces: At most this many scatterings between a light and the camera; 7 by default.
        method: ``reference``, without bias, or ``cache``; by default what takes less time.
        tone: How PNGs show light: ``photograph`` as a camera, ``film`` by the curve alone, ``srgb``
            with nothing but the encoding. Data is never toned.
        f_stop: F-number of a lens before film 36 mm wide, such as 2.8 (docs/light.md).
        storage: How files hold channels: ``complete``, or ``compact``, some ten times smaller,
            light with a small loss (docs/storage.md). Both are read alike.
        grid: Columns and rows of hemispheres, where channels of them are asked for; (160, 120).
        error_maps: Whether to write the estimated standard error of each pixel too.
        denoise: Whether to write ``denoised`` beside ``radiance`` (extra ``denoise``); ``"all"``:
            also ``denoised_channels.exr`` and ``denoised_lights.exr`` (docs/light.md).
        time_code: When a stage that moves is seen; None for the first sample of everything.
        default_light: Whether a stage without any light gets one (docs/usd.md); else it is dark.
        texture_side: The longest side of textures, pixels: longer ones are halved until they fit.
            None: 4096, or less where all together would take more than 2 GB.
        renderer: A registered renderer.
        options: What is asked of the renderer, by name: Mitsuba has ``variant`` and ``bsdf``.
        progress: Called with the view's name and the finished fraction of the whole.

    Returns:
        The render: views by name, which hold arrays by the channel's name.

    Raises:
        InputError: The scene is unreadable, a name is unknown or a number is absurd.
        MissingPackageError: The denoiser is asked for and not installed.
        OutputError: The folder cannot be written.
        RenderError: The renderer cannot do it.
    """
    from openrooms_usd.render.contract import DEFAULT_BOUNCES, DEFAULT_GRID
    from openrooms_usd.render.driver import render_stage
    from openrooms_usd.usd.diagnostics import quiet
    from openrooms_usd.usd.layers import open_stage
    from openrooms_usd.usd.metrics import find_misfits

    file = usd_file(scene)
    folder = file.parent / _RENDER if out is None else path_of(out)
    with quiet():
        for misfit in find_misfits(open_stage(file)):
            _LOG.warning("%s: see orusd edits fit", misfit)
        summary = render_stage(
            file,
            folder,
            cameras=[cameras] if isinstance(cameras, str) else list(cameras),
            channels=names_of(channels),
            resolution=None if resolution is None else size_of(resolution, "resolution"),
            field_of_view=field_of_view,
            grid=DEFAULT_GRID if grid is None else size_of(grid, "grid"),
            error_maps=error_maps,
            samples=samples,
            error=error,
            seconds=seconds,
            seed=seed,
            bounces=DEFAULT_BOUNCES if bounces is None else bounces,
            method=method,
            tone=tone,
            f_stop=f_stop,
            storage=storage,
            renderer=renderer,
            denoise=denoise,
            time_code=time_code,
            default_light=default_light,
            texture_side=texture_side,
            options=options or {},
            progress=progress,
        )
    for path in summary.stay:
        _LOG.warning("%s stays: it is no view of this run, and holds what no run wrote", path)
    return read_render(folder)


def compare(
    scene: AnyPath,
    out: AnyPath,
    *,
    room: AnyPath | None = None,
    photographs: AnyPath | None = None,
    frames: str | Sequence[str] = (),
    count: int | None = None,
    width: int | None = None,
    samples: int | None = None,
    renderer: str = "mitsuba",
    options: Mapping[str, str] | None = None,
    progress: Progress = silent,
) -> "Comparison":
    """Render a room from the cameras of its photographs, and put all side by side.

    Args:
        scene: A room that was composed from a capture with cameras.
        out: The folder to write: ``comparison.json``, ``contact_sheet.png``, ``frames/``.
        room: The room.yaml it was composed from; by default beside the folder of the scene.
        photographs: The folder of the pictures; by default that of the capture.
        frames: Identifiers of frames; by default ``count`` of all, evenly spread.
        count: How many frames at most; 8 by default.
        width: Of the pictures, pixels; 480 by default.
        samples: Samples a pixel; 32 by default.
        renderer: A registered renderer.
        options: What is asked of the renderer, by name.
        progress: Called with the frame's name and the finished fraction of the whole.

    Returns:
        ``.frames``: of each how many edges of the render the photograph has, and how far its depth
        is from the scan's.

    Raises:
        InputError: A file is missing or damaged, the room comes from no capture with cameras, or
            there is no such frame.
        OutputError: The folder cannot be written.
        RenderError: The renderer cannot do it.
    """
    from openrooms_usd.comparison import driver
    from openrooms_usd.usd.diagnostics import quiet

    with quiet():
        return driver.compare_stage(
            usd_file(scene),
            path_of(out),
            description=None if room is None else path_of(room, "a room.yaml"),
            pictures=None if photographs is None else path_of(photographs),
            frames=[frames] if isinstance(frames, str) else list(frames),
            count=driver.DEFAULT_COUNT if count is None else count,
            width=driver.DEFAULT_WIDTH if width is None else width,
            samples=driver.DEFAULT_SAMPLES if samples is None else samples,
            renderer=renderer,
            options=options or {},
            progress=progress,
        )
