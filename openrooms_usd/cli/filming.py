"""What ``render --path`` does: a camera path as a video."""

from pathlib import Path
from typing import Any

from openrooms_usd.cli.console import echo, print_json, progress_bar
from openrooms_usd.description.rendering import RenderSettings


def film(
    stage: Path, out: Path, spec: str, settings: RenderSettings, as_json: bool, **how: Any
) -> None:
    """Render a path and say what came of it.

    Args:
        stage: The USD file.
        out: The folder.
        spec: The path, as `openrooms_usd.rendering.paths.rendering.render_path` takes it.
        settings: What is asked for.
        as_json: Whether to print JSON.
        how: What else it takes.
    """
    from openrooms_usd.rendering.paths.rendering import render_path
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet(), progress_bar(hidden=as_json, first="translating") as progress:
        summary = render_path(stage, out, spec, settings, progress=progress, **how)
    if as_json:
        print_json(summary.as_dict())
        return
    told, spent = summary.manifest, sum(summary.timing.values())
    width, height = told["resolution"]
    echo(f"{len(told['frames'])} frames of {width}x{height}, {spent:.2f} s each")
    flickers = told["flicker"]
    if flickers["mean"] is not None:
        echo(f"flicker {flickers['mean']:.2g}, stated error {flickers['stated']:.2g} (relative)")
    echo(f"wrote {summary.video} and {summary.cameras.name}")
