"""Camera paths as videos."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from openrooms_usd.api.given import AnyPath, path_of, size_of, usd_file
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from openrooms_usd.render.paths.rendering import PathSummary

_PATHS: Final = "paths"


def render_path(
    scene: AnyPath,
    out: AnyPath | None = None,
    *,
    path: AnyPath = "walk",
    duration: float | None = None,
    fps: int | None = None,
    frames: bool = False,
    resolution: tuple[int, int] | None = None,
    samples: int | None = None,
    seed: int = 0,
    bounces: int | None = None,
    method: str | None = None,
    tone: str = "photograph",
    denoise: bool = False,
    renderer: str = "mitsuba",
    options: Mapping[str, str] | None = None,
    progress: Progress = silent,
) -> "PathSummary":
    """Render a camera path of a scene as a video, with the camera of every frame.

    Args:
        scene: A composed room or any USD file.
        out: The folder to write; by default ``paths`` beside the scene.
        path: ``walk`` finds a way past the scene's cameras; else the name of a camera that has
            time samples, or a file of keys (docs/paths.md).
        duration: Seconds; by default as long as the path is, 10 for a walk.
        fps: Frames a second; 24 by default.
        frames: Whether to write every frame too, with its ground truth.
        resolution: Width and height in pixels, even numbers; 320x240 by default.
        samples: Samples a pixel of a frame; 4 by default.
        seed: Fixes every random number.
        bounces: At most this many scatterings between a light and the camera; 7 by default.
        method: As of `render`; ``cache`` by default where the renderer has it.
        tone: As of `render`, one for the whole film.
        denoise: Whether frames are denoised (extra ``denoise``).
        renderer: A registered renderer that gives light.
        options: What is asked of the renderer, by name.
        progress: Called with the path's name and the finished fraction.

    Returns:
        ``.video`` and ``.cameras`` are files, ``.frames`` the folder of frames, ``.manifest`` what
        stands in ``.cameras``.

    Raises:
        InputError: There is no such path, or a number is absurd.
        MissingPackageError: What encodes videos (extra ``video``), or the denoiser, is missing.
        OutputError: The folder cannot be written.
        RenderError: There is no room for a walk, or the renderer cannot do it.
    """
    from openrooms_usd.render.contract import DEFAULT_BOUNCES, DEFAULT_RATE
    from openrooms_usd.render.paths import rendering
    from openrooms_usd.usd.diagnostics import quiet

    file = usd_file(scene)
    with quiet():
        return rendering.render_path(
            file,
            file.parent / _PATHS if out is None else path_of(out),
            str(path),
            seconds=duration,
            rate=DEFAULT_RATE if fps is None else fps,
            resolution=None if resolution is None else size_of(resolution, "resolution"),
            samples=samples,
            seed=seed,
            bounces=DEFAULT_BOUNCES if bounces is None else bounces,
            method=method,
            tone=tone,
            renderer=renderer,
            options=options or {},
            denoise=denoise,
            keep_frames=frames,
            progress=progress,
        )
