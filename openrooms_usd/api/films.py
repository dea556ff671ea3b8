"""Camera paths as videos."""

from typing import TYPE_CHECKING, Any, Final

from openrooms_usd.api.given import AnyPath, path_of, usd_file
from openrooms_usd.api.settings import FILM, settings_of, takes_settings
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from openrooms_usd.description.rendering import RenderSettings
    from openrooms_usd.rendering.paths.rendering import PathSummary

_PATHS: Final = "paths"


@takes_settings(*FILM, samples="Samples a pixel of a frame; 4 by default.")
def render_path(
    scene: AnyPath,
    out: AnyPath | None = None,
    *,
    path: AnyPath = "walk",
    duration: float | None = None,
    fps: int | None = None,
    frames: bool = False,
    settings: "RenderSettings | None" = None,
    progress: Progress = silent,
    **fields: Any,
) -> "PathSummary":
    """Render a camera path of a scene as a video, with the camera of every frame.

    Args:
        scene: A composed room or any USD file.
        out: The folder to write; by default ``paths`` beside the scene.
        path: ``walk`` finds a way past the scene's cameras; else the name of a camera that has
            time samples, or a file of keys (docs/howto/paths.md).
        duration: Seconds; by default as long as the path is, 10 for a walk.
        fps: Frames a second; 24 by default.
        frames: Whether to write every frame too, with its ground truth.
        settings: What is asked for, in one record.
        progress: Called with the path's name and the finished fraction.
        **fields: The same, by name:

    Returns:
        ``.video`` and ``.cameras`` are files, ``.frames`` the folder of frames, ``.manifest`` what
        stands in ``.cameras``.

    Raises:
        InputError: There is no such path, or a number is absurd.
        MissingPackageError: What encodes videos (extra ``video``), or the denoiser, is missing.
        OutputError: The folder cannot be written.
        RenderError: There is no room for a walk, or the renderer cannot do it.
    """
    from openrooms_usd.rendering.contract import DEFAULT_RATE
    from openrooms_usd.rendering.paths import rendering
    from openrooms_usd.usd.files.diagnostics import quiet

    file = usd_file(scene)
    wanted = settings_of(settings, fields, FILM)
    with quiet():
        return rendering.render_path(
            file,
            file.parent / _PATHS if out is None else path_of(out),
            str(path),
            wanted,
            seconds=duration,
            rate=DEFAULT_RATE if fps is None else fps,
            keep_frames=frames,
            progress=progress,
        )
