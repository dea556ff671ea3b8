"""Renders the cameras of a stage into files: pictures, ground truth and one manifest."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from openrooms_usd import claims, ledger
from openrooms_usd.convert import Report
from openrooms_usd.progress import Progress, part, silent
from openrooms_usd.render import folder, manifest
from openrooms_usd.render.contract import (
    COMPLETE,
    DEFAULT_BOUNCES,
    DEFAULT_GRID,
    NO_OPTIONS,
    PHOTOGRAPH,
)
from openrooms_usd.render.denoised_light import Denoise
from openrooms_usd.render.job import RenderJob
from openrooms_usd.render.run import Run, raw_bytes
from openrooms_usd.render.writer import ViewWriter, view_writer


@dataclass(frozen=True)
class RenderSummary:
    """What a run wrote.

    Attributes:
        out: The folder.
        manifest: What stands in ``manifest.json``.
        timing: What stands in ``timing.json``.
        stay: Views of an earlier run that are not described any more, and not ours to remove.
        report: What became of every prim.
    """

    out: Path
    manifest: Mapping[str, Any]
    timing: Mapping[str, Any]
    stay: tuple[Path, ...] = ()
    report: Report = field(default_factory=Report)

    def as_dict(self) -> dict[str, Any]:
        """The summary as plain data."""
        return {"out": str(self.out), "manifest": self.manifest, "timing": self.timing}


def render_stage(
    path: Path,
    out: Path,
    *,
    cameras: Sequence[str] = (),
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
    time_code: float | None = None,
    default_light: bool = True,
    texture_side: int | None = None,
    progress: Progress = silent,
) -> RenderSummary:
    """Render cameras of a USD stage with their ground truth.

    ``out`` then holds a folder for every view (``channels.exr``, ``radiance.exr``, a PNG for every
    channel), ``contact_sheet.png``, ``manifest.json`` and ``timing.json``, and no view of an
    earlier run. Views appear whole: whatever interrupts the run, the finished ones stay and the
    manifest lists them.

    Args:
        path: The USD file.
        out: The folder to write.
        cameras: Names or prim paths; all cameras where empty, and a framing camera where the stage
            has none.
        channels: Names from `openrooms_usd.channels.CHANNELS`; None for all the renderer gives, and
            what is made of them.
        resolution: Width and height in pixels; None for what the stage's render settings say.
        field_of_view: Horizontal, degrees, of all cameras; None for what each has.
        grid: Columns and rows of hemispheres, where channels of them are asked for.
        error_maps: Whether to write the estimated standard error of each pixel too.
        samples: Samples a pixel; `DEFAULT_SAMPLES` where neither ``error`` nor ``seconds`` is.
        error: Stop a view at this estimated robust error of its radiance.
        seconds: Stop a view after about this time.
        seed: Fixes every random number.
        bounces: At most this many scatterings on the way from a light to the camera.
        method: One of `openrooms_usd.render.contract.METHODS`; None for what the renderer takes
            where nobody asks.
        tone: How pictures for people show light; one of `openrooms_usd.render.contract.TONES`.
        f_stop: F-number of a lens before film 36 mm wide, in place of the cameras' own, focused as
            they say or on what is in the middle of the picture.
        storage: How files hold channels: ``complete``, or ``compact`` (docs/storage.md).
        renderer: A registered renderer.
        options: What is asked of the renderer, by the names that it declares.
        denoise: Whether to write the denoised radiance beside the raw one; ``all``: also denoised
            versions of every channel of light that can bear it, whose bias the manifest states.
        time_code: When a stage that moves is seen; None for the first sample of everything.
        default_light: Whether a stage without any light gets one (docs/usd.md); else it is dark.
        texture_side: The longest side of textures, pixels: longer ones are halved until they fit.
            None: 4096, or less where all together would take more than 2 GB.
        progress: Called with the view's name and the finished fraction of the whole run.

    Returns:
        What was written.

    Raises:
        InputError: The stage is unreadable, a name is unknown, a number is absurd, or nobody gives
            a channel with this renderer.
        MissingPackageError: The denoiser is asked for and not installed.
        OutputError: The folder cannot be written.
        RenderError: The renderer cannot do it.
    """
    # 1. Refuse what cannot work before anything slow begins.
    job = RenderJob.of(
        channels=channels,
        resolution=resolution,
        field_of_view=field_of_view,
        grid=grid,
        error_maps=error_maps,
        samples=samples,
        error=error,
        seconds=seconds,
        seed=seed,
        bounces=bounces,
        method=method,
        tone=tone,
        f_stop=f_stop,
        storage=storage,
        renderer=renderer,
        options=options,
        denoise=denoise,
        time_code=time_code,
        default_light=default_light,
        texture_side=texture_side,
    )
    folder.check_writable(out)

    with claims.claimed(out, ledger.RENDER_FILE) as kept:
        # 2. Translate the stage.
        opened = job.open(path, cameras)
        folder.check_replaceable(out, opened.views)
        folder.check_space(out, raw_bytes(opened.listed, len(opened.lights)))

        # 3. Render view by view; each is written, and then in the manifest, beside the next.
        session, views = opened.opened.session, opened.views
        run = Run(out, opened.entry(), opened.report, kept, opened.lights)
        run.timing |= {
            "machine": manifest.machine_entry(session.backend),
            "translation": opened.translation,
        }
        with view_writer() as writer:
            for index, name in enumerate(views):
                share = part(partial(_checked, writer, progress), name, index, len(views))
                began = time.perf_counter()
                view = opened.render(name, share)
                took = time.perf_counter() - began
                shown = opened.photograph(name)
                # What is told of the next view is no part of this one's manifest.
                told = opened.report.as_dict()
                writer.put(view, partial(run.add, name, view, opened.listed, took, shown, told))
    made = run.manifest, run.timing
    return RenderSummary(out, *made, tuple(run.stay), opened.report)


def _checked(writer: ViewWriter, progress: Progress, what: str, fraction: float) -> None:
    """Progress of what is rendered while a view before is written, which may fail."""
    writer.check()
    progress(what, fraction)
