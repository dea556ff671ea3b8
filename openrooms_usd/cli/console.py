"""What the commands share: ``--json``, how text and a result are printed, a bar of progress."""

import json
import shlex
import sys
import threading
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

import click

from openrooms_usd.errors import printable
from openrooms_usd.progress import Progress, silent
from openrooms_usd.spelling import did_you_mean, listed

Command = TypeVar("Command", bound=Callable[..., Any])
Said = TypeVar("Said", bound=Hashable)
_LINE_SECONDS: Final = 10.0
# How many of those are named of which the same is said.
_NAMED: Final = 3


if TYPE_CHECKING:
    _Choice = click.Choice[str]
else:
    # Older ones of click are no generic.
    _Choice = click.Choice


class Choice(_Choice):
    """One of several words; what is none is answered with the nearest."""

    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:
        """What is wrong, and what may have been meant."""
        said = super().get_invalid_choice_message(value, ctx)
        return f"{said.removesuffix('.')}{did_you_mean(value, map(str, self.choices))}."


class Group(click.Group):
    """A group of commands; one that it does not have is answered with the nearest."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command.

        Raises:
            UsageError: There is none of that name.
        """
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            if args[0].startswith("-"):
                raise
            hint = did_you_mean(args[0], self.list_commands(ctx))
            raise click.UsageError(f"No such command {args[0]!r}{hint}.", ctx) from error


def json_option(command: Command) -> Command:
    """Add ``--json``: print one JSON document and nothing else on standard output."""
    return click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")(
        command
    )


def echo(text: object = "", *, err: bool = False, nl: bool = True) -> None:
    """Print for people: names from files cannot move the cursor or forge what stands there."""
    click.echo(printable(text), err=err, nl=nl)


def echo_notes(notes: Iterable[str], indent: str = "") -> None:
    """Print notes, each once."""
    for note, count in Counter(notes).items():
        echo(f"{indent}note: {note}{f' ({count} times)' if count > 1 else ''}")


def gathered(rows: Iterable[tuple[Said, str]]) -> Iterator[tuple[Said, list[str]]]:
    """What is said of many names, once each in the order in which it was said first.

    Args:
        rows: What is said, and of whom.
    """
    names: dict[Said, list[str]] = {}
    for said, name in rows:
        names.setdefault(said, []).append(name)
    yield from names.items()


def named(names: Sequence[str]) -> str:
    """A name, or the first of several and how many there are."""
    if len(names) == 1:
        return names[0]
    return f"{len(names)} x: {listed(names, _NAMED)}"


def command_line(*words: str | Path) -> str:
    """A command that can be pasted into a shell, whatever its paths are called."""
    return shlex.join(str(word) for word in words)


def print_json(data: object) -> None:
    """Print data as JSON, in one stable form."""
    click.echo(json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False))


@contextmanager
def progress_bar(*, hidden: bool, first: str = "") -> Iterator[Progress]:
    """A bar on standard error where that is a terminal, else a plain line every some seconds.

    Args:
        hidden: Whether there shall be none.
        first: What is worked on at first.
    """
    if hidden:
        yield silent
        return
    if not sys.stderr.isatty():
        with _lines(first) as told:
            yield told
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TimeRemainingColumn

    columns = ("[progress.description]{task.description}", BarColumn(), TaskProgressColumn())
    with Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True)) as bar:
        task = bar.add_task(first, total=1.0)
        yield lambda text, fraction: bar.update(task, description=text, completed=fraction)


@contextmanager
def _lines(first: str) -> Iterator[Progress]:
    """Progress as lines, for logs: the latest, where there is something new to say."""
    latest, ended = [(first, 0.0)], threading.Event()

    def tell() -> None:
        said: tuple[str, float] | None = None
        while not ended.wait(_LINE_SECONDS):
            if latest[0] != said:
                said = latest[0]
                echo(f"{said[1]:4.0%} {said[0]}", err=True)

    def take(what: str, fraction: float) -> None:
        latest[0] = what, fraction

    thread = threading.Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield take
    finally:
        ended.set()
        thread.join()
