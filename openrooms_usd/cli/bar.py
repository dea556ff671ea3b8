"""Progress: a bar on a terminal, lines in a log, and with ``--verbose`` the time of each step."""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from datetime import timedelta
from time import perf_counter
from typing import Final

from openrooms_usd.cli.console import asked, echo
from openrooms_usd.progress import Counted, Progress, silent

# Seconds between the lines of a log.
_LINE_SECONDS: Final = 10.0


@contextmanager
def progress_bar(first: str) -> Iterator[Progress]:
    """Show a command's progress on standard error, unless ``--quiet``.

    Args:
        first: What is worked on at first.
    """
    output = asked()
    is_terminal = sys.stderr.isatty()
    is_shown = not output.quiet and (is_terminal or not (output.verbose or output.json))
    kind = _bar if is_terminal else _lines
    with kind(first) if is_shown else nullcontext(silent) as shown:
        if not output.verbose:
            yield shown
            return
        with _timed(first, shown) as timed:
            yield timed


@contextmanager
def _bar(first: str) -> Iterator[Progress]:
    """What is worked on, the share of it that is done, the time that went by and that is left."""
    from rich import progress
    from rich.console import Console
    from rich.text import Text

    class Left(progress.ProgressColumn):
        """The time left at the mean speed until the last step, counted down since."""

        def render(self, task: progress.Task) -> Text:
            if task.fields["end"] is None:
                return Text()
            seconds = max(0.0, task.fields["end"] - perf_counter())
            return Text(f"{timedelta(seconds=round(seconds))} left")

    began = perf_counter()
    columns = (
        progress.TextColumn("{task.description}", markup=False),
        progress.BarColumn(),
        progress.TaskProgressColumn(),
        progress.TimeElapsedColumn(),
        Left(),
    )
    with progress.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        # Without a total the bar swings: how long it takes cannot be known yet.
        task = bar.add_task(first, total=None, end=None)

        def show(what: str, fraction: float) -> None:
            known = fraction > 0.0
            end = began + (perf_counter() - began) / fraction if known else None
            named, total = _label(what or first), 1.0 if known else None
            bar.update(task, description=named, completed=fraction, total=total, end=end)

        yield show


@contextmanager
def _lines(first: str) -> Iterator[Progress]:
    """Progress for logs: every few seconds a line, where it says something new."""
    latest, ended = [(first, 0.0)], threading.Event()

    def report() -> None:
        reported: tuple[str, float] | None = None
        while not ended.wait(_LINE_SECONDS):
            if latest[0] != reported:
                reported = latest[0]
                echo(f"{reported[1]:4.0%} {_label(reported[0])}", err=True)

    def take(what: str, fraction: float) -> None:
        latest[0] = what or first, fraction

    thread = threading.Thread(target=report, daemon=True)
    thread.start()
    try:
        yield take
    finally:
        ended.set()
        thread.join()


def _label(what: str) -> str:
    return what.told if isinstance(what, Counted) else what


@contextmanager
def _timed(first: str, shown: Progress) -> Iterator[Progress]:
    """Print each step when it ends, with its seconds."""
    step, began = first, perf_counter()

    def tell() -> None:
        echo(f"{perf_counter() - began:8.2f} s  {_label(step)}", err=True)

    def take(what: str, fraction: float) -> None:
        nonlocal step, began
        if what != step:
            tell()
            step, began = what, perf_counter()
        shown(what, fraction)

    yield take
    tell()
