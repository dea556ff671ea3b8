"""Renders the cameras of a stage into files: pictures, ground truth and one manifest."""

import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from openrooms_usd import claims, ledger
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.exporters import Report
from openrooms_usd.progress import Progress, part, silent
from openrooms_usd.rendering import folder, manifest
from openrooms_usd.rendering.contract import View, ViewProgress
from openrooms_usd.rendering.plan import is_spare
from openrooms_usd.rendering.run import Run, raw_bytes

if TYPE_CHECKING:
    from openrooms_usd.rendering.context import RenderContext

# A view that takes more than this is written before the next is rendered.
_MOST_BESIDE_BYTES: Final = 1 << 29
# What writing has left when the run is interrupted.
_GRACE_SECONDS: Final = 1.0


# One view is written at a time, by a thread beside that which renders; who has the next one waits
# for it. So views appear in their order, and at most two are in memory. One that is large is
# waited for at once. When the run is interrupted, what is all but written has a moment to be
# finished.
class InterruptedWritingError(Exception):
    """Writing has stopped because the run has; it is never shown."""


class ViewWriter:
    """Writes views one after the other, beside what goes on."""

    def __init__(self, pool: ThreadPoolExecutor) -> None:
        self._pool = pool
        self._now: Future[None] | None = None
        self._stopped = threading.Event()

    def put(self, view: View, write: Callable[[Callable[[], None]], None]) -> None:
        """Have a view written, once the one before is.

        Args:
            view: What is written.
            write: Writes it; calls what it is given from time to time, which raises when it shall
                stop.

        Raises:
            OrusdError: The view before could not be written.
        """
        self.wait()
        self._now = self._pool.submit(write, self._check_going)
        if _bytes(view) > _MOST_BESIDE_BYTES:
            self.wait()

    def check(self) -> None:
        """Raise what has kept a view from being written, if anything has."""
        if self._now is not None and self._now.done():
            self.wait()

    def wait(self) -> None:
        """Wait until everything is written.

        Raises:
            OrusdError: It could not be.
        """
        if self._now is not None:
            now, self._now = self._now, None
            now.result()

    def stop(self) -> None:
        """Stop writing, and forget what has not been written in a moment."""
        if self._now is not None:
            wait([self._now], _GRACE_SECONDS)
        self._stopped.set()

    def _check_going(self) -> None:
        if self._stopped.is_set():
            raise InterruptedWritingError


@contextmanager
def view_writer() -> Iterator[ViewWriter]:
    """What writes views beside the block; at its end everything is written.

    When the block raises, what is then being written is finished in a moment, or leaves nothing.
    """
    with ThreadPoolExecutor(max_workers=1) as pool:
        writer = ViewWriter(pool)
        try:
            yield writer
            writer.wait()
        except BaseException:
            writer.stop()
            raise


def _bytes(view: View) -> int:
    images = view.images.values()
    halves = (image.halves for image in images if image.halves)
    kept = sum(half.a.nbytes + half.b.nbytes for half in halves)
    clean = sum(image.pixels.nbytes for image in view.denoised.values())
    return kept + clean + sum(image.pixels.nbytes for image in images)


@dataclass(frozen=True)
class RenderSummary:
    """What a run wrote.

    Attributes:
        out: The folder.
        manifest: What stands in ``manifest.json``.
        timing: What stands in ``timing.json``.
        stay: Views of an earlier run that are not described any more, and not ours to remove.
        report: What became of every prim.
        spares: Spare cameras of the room, which are not rendered.
    """

    out: Path
    manifest: Mapping[str, Any]
    timing: Mapping[str, Any]
    stay: tuple[Path, ...] = ()
    report: Report = field(default_factory=Report)
    spares: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The summary as plain data."""
        return {"out": str(self.out), "manifest": self.manifest, "timing": self.timing}


def render_stage(
    path: Path,
    out: Path,
    settings: RenderSettings | None = None,
    *,
    cameras: Sequence[str] = (),
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
        settings: What is asked for.
        cameras: Names or prim paths; all cameras but spare ones where empty, and a framing camera
            where the stage has none.
        progress: Called with the view's name and the finished fraction of the whole run.

    Returns:
        What was written.

    Raises:
        InputError: The stage is unreadable, or a name is unknown.
        MissingPackageError: The renderer or the denoiser needs a package that is not installed.
        OutputError: The folder cannot be written.
        RenderError: The renderer cannot do it.
    """
    from openrooms_usd.rendering.opening import check_settings, open_for_rendering

    # 1. Refuse what cannot work before anything slow begins.
    settings = settings or RenderSettings()
    check_settings(settings)
    folder.check_writable(out)
    with claims.claimed(out, ledger.RENDER_FILE) as kept:
        # 2. Translate the stage.
        context = open_for_rendering(path, settings, cameras=cameras)
        # 3. Render view by view.
        views = {name: partial(context.view, name) for name in context.views}
        summary = write_views(context, out, kept, views, progress)
    drawn = context.views.values()
    spares = [path for path in context.cameras if is_spare(path) and path not in drawn]
    return summary if cameras else replace(summary, spares=tuple(spares))


def write_views(
    context: "RenderContext",
    out: Path,
    kept: ledger.Ledger,
    views: Mapping[str, Callable[[ViewProgress], View]],
    progress: Progress = silent,
) -> RenderSummary:
    """Render views of an opened stage into files; each is written beside the next.

    Args:
        context: The opened stage.
        out: The folder, which this process has claimed.
        kept: The ledger of the folder.
        views: What renders each view, by its name.
        progress: Called with the view's name and the finished fraction of the whole run.

    Raises:
        OutputError: The folder cannot be written.
        RenderError: The renderer cannot do it.
    """
    listed, settings, report = context.listed, context.settings, context.report
    folder.check_replaceable(out, views)
    folder.check_space(out, raw_bytes(listed, len(context.lights)))
    run = Run(
        out,
        context.entry(),
        report,
        kept,
        context.lights,
        storage=settings.storage,
        tone=settings.tone,
    )
    run.timing |= {
        "machine": manifest.machine_entry(context.session.backend),
        "translation": context.translation,
    }
    with view_writer() as writer:
        for index, (name, render) in enumerate(views.items()):
            share = part(partial(_checked, writer, progress), name, index, len(views))
            began = time.perf_counter()
            view = render(share)
            took = time.perf_counter() - began
            is_own = name in context.views and view.camera == context.views[name]
            shown = context.photograph(name) if is_own else None
            # Cameras may have sizes of their own.
            sized = replace(listed, width=view.width, height=view.height)
            # Reports on the next view do not belong in this one's manifest.
            told = report.as_dict()
            writer.put(view, partial(run.add, name, view, sized, took, shown, told))
    return RenderSummary(out, run.manifest, run.timing, tuple(run.stay), report)


def _checked(writer: ViewWriter, progress: Progress, what: str, fraction: float) -> None:
    """Progress of what is rendered while a view before is written, which may fail."""
    writer.check()
    progress(what, fraction)
