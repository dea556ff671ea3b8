"""Progress: a bar on a terminal, and with ``--verbose`` the time of each step."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from time import perf_counter
from typing import Final

from openrooms_usd.cli.console import asked, echo
from openrooms_usd.progress import Progress, silent

# The time left is told from the mean speed of so many seconds: a day is all.
_SPEED_SECONDS: Final = 86_400.0


@contextmanager
def progress_bar(first: str) -> Iterator[Progress]:
    """Show how far a command is, where standard error is a terminal and nobody asked for quiet.

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

    columns = (
        progress.TextColumn("{task.description}", markup=False),
        progress.BarColumn(),
        progress.TaskProgressColumn(),
        progress.TimeElapsedColumn(),
        progress.TextColumn("left:"),
        progress.TimeRemainingColumn(),
    )
    with progress.Progress(
        *columns, console=Console(stderr=True), transient=True, speed_estimate_period=_SPEED_SECONDS
    ) as bar:
        # Without a total the bar swings: how long it takes cannot be known yet.
        task = bar.add_task(first, total=None)

        def show(what: str, fraction: float) -> None:
            total = 1.0 if fraction > 0.0 else None
            bar.update(task, description=what or first, completed=fraction, total=total)

        yield show


@contextmanager
def _timed(first: str, shown: Progress) -> Iterator[Progress]:
    """Print each step when it ends, with its seconds."""
    step, began = first, perf_counter()

    def tell() -> None:
        echo(f"{perf_counter() - began:8.2f} s  {step}", err=True)

    def take(what: str, fraction: float) -> None:
        nonlocal step, began
        if what != step:
            tell()
            step, began = what, perf_counter()
        shown(what, fraction)

    yield take
    tell()
