"""Pictures with ground truth, and rooms beside their photographs."""

import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from openrooms_usd.api.given import AnyPath, path_of, usd_file
from openrooms_usd.api.rendered import Render, open_render
from openrooms_usd.api.settings import ALL, BAKE, settings_of, takes_settings
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from openrooms_usd.comparison.driver import Comparison
    from openrooms_usd.description.rendering import RenderSettings

_LOG: Final = logging.getLogger("openrooms_usd")
_RENDER: Final = "render"


@takes_settings(*ALL)
def render(
    scene: AnyPath,
    out: AnyPath | None = None,
    *,
    cameras: str | Sequence[str] = (),
    settings: "RenderSettings | None" = None,
    progress: Progress = silent,
    **fields: Any,
) -> Render:
    """Render the cameras of a scene with their ground truth.

    Args:
        scene: A composed room or any USD file.
        out: The folder to write; by default ``render`` beside the scene.
        cameras: Names or prim paths; all cameras but spare ones by default.
        settings: What is asked for, in one record.
        progress: Called with the view's name and the finished fraction of the whole.
        **fields: The same, by name:

    Returns:
        The render: views by name, which hold arrays by the channel's name.

    Raises:
        InputError: The scene is unreadable, a name is unknown or a number is outside its limits.
        MissingPackageError: The denoiser is asked for and not installed.
        OutputError: The folder cannot be written.
        RenderError: The renderer cannot do it.
    """
    from openrooms_usd.rendering.driver import render_stage
    from openrooms_usd.usd.files.diagnostics import quiet
    from openrooms_usd.usd.files.layers import open_stage
    from openrooms_usd.usd.places.metrics import find_unit_mismatches

    file = usd_file(scene)
    folder = file.parent / _RENDER if out is None else path_of(out)
    wanted = settings_of(settings, fields)
    with quiet():
        for misfit in find_unit_mismatches(open_stage(file)):
            _LOG.warning("%s: see orusd edit fix-units", misfit)
        names = [cameras] if isinstance(cameras, str) else list(cameras)
        summary = render_stage(file, folder, wanted, cameras=names, progress=progress)
    for path in summary.stay:
        _LOG.warning(
            "%s is kept: this run did not render it, and it holds files that no run wrote", path
        )
    return open_render(folder)


@takes_settings(*BAKE, samples="Samples a pixel; 32 by default.")
def compare(
    scene: AnyPath,
    out: AnyPath,
    *,
    room: AnyPath | None = None,
    photographs: AnyPath | None = None,
    frames: str | Sequence[str] = (),
    count: int | None = None,
    width: int | None = None,
    settings: "RenderSettings | None" = None,
    progress: Progress = silent,
    **fields: Any,
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
        settings: What is asked for, in one record.
        progress: Called with the frame's name and the finished fraction of the whole.
        **fields: The same, by name:

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
    from openrooms_usd.usd.files.diagnostics import quiet

    wanted = settings_of(settings, fields, BAKE)
    with quiet():
        return driver.compare_stage(
            usd_file(scene),
            path_of(out),
            wanted,
            description=None if room is None else path_of(room, "a room.yaml"),
            pictures=None if photographs is None else path_of(photographs),
            frames=[frames] if isinstance(frames, str) else list(frames),
            count=driver.DEFAULT_COUNT if count is None else count,
            width=driver.DEFAULT_WIDTH if width is None else width,
            progress=progress,
        )
