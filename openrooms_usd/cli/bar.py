"""Progress: a bar on a terminal, and with ``--verbose`` the time of each step."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from datetime import timedelta
from time import perf_counter

from openrooms_usd.cli.console import asked, echo
from openrooms_usd.progress import Counted, Progress, silent


@contextmanager
def progress_bar(first: str) -> Iterator[Progress]:
    """Show how far a command is, on a terminal and without ``--quiet``.

    Args:
        first: What is worked on at first.
    """
    output = asked()
    is_shown = sys.stderr.isatty() and not output.quiet
    with _bar(first) if is_shown else nullcontext(silent) as shown:
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
            named, total = _told(what or first), 1.0 if known else None
            bar.update(task, description=named, completed=fraction, total=total, end=end)

        yield show


def _told(what: str) -> str:
    return what.told if isinstance(what, Counted) else what


@contextmanager
def _timed(first: str, shown: Progress) -> Iterator[Progress]:
    """Print each step when it ends, with its seconds."""
    step, began = first, perf_counter()

    def tell() -> None:
        echo(f"{perf_counter() - began:8.2f} s  {_told(step)}", err=True)

    def take(what: str, fraction: float) -> None:
        nonlocal step, began
        if what != step:
            tell()
            step, began = what, perf_counter()
        shown(what, fraction)

    yield take
    tell()
