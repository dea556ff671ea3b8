"""What the commands share: ``--json``, how text and a result are printed, a bar of progress."""

import json
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from openrooms_usd.errors import printable
from openrooms_usd.progress import Progress, silent
from openrooms_usd.spelling import did_you_mean

Command = TypeVar("Command", bound=Callable[..., Any])


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


def command_line(*words: str | Path) -> str:
    """A command that can be pasted into a shell, whatever its paths are called."""
    return shlex.join(str(word) for word in words)


def print_json(data: object) -> None:
    """Print data as JSON, in one stable form."""
    click.echo(json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False))


@contextmanager
def progress_bar(*, hidden: bool, first: str = "") -> Iterator[Progress]:
    """A bar on standard error where that is a terminal, else nothing.

    Args:
        hidden: Whether there shall be none.
        first: What is worked on at first.
    """
    if hidden or not sys.stderr.isatty():
        yield silent
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TimeRemainingColumn

    columns = ("[progress.description]{task.description}", BarColumn(), TaskProgressColumn())
    with Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True)) as bar:
        task = bar.add_task(first, total=1.0)
        yield lambda text, fraction: bar.update(task, description=text, completed=fraction)
