"""What the commands print: what was asked for, what was done, warnings, and JSON."""

import json
import os
import sys
from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, redirect_stdout
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar

import click

from openrooms_usd.errors import printable
from openrooms_usd.portable import shell_line
from openrooms_usd.spelling import did_you_mean, listed

if TYPE_CHECKING:
    from rich.table import Table

Said = TypeVar("Said", bound=Hashable)
# How many of those are named of which the same is said.
_NAMED: Final = 3
# Where click keeps what was asked for, from one command to the next below it.
_KEY: Final = "openrooms_usd.output"


class Output(NamedTuple):
    """How much is printed, and in which form."""

    quiet: bool = False
    verbose: bool = False
    json: bool = False


def asked(context: click.Context | None = None) -> Output:
    """The output options of the running command.

    Args:
        context: Of the command; the one that runs by default.
    """
    context = context or click.get_current_context(silent=True)
    found = context.meta.get(_KEY) if context else None
    return found if isinstance(found, Output) else Output()


def remember(context: click.Context, name: str) -> None:
    """Note that one of the options of `Output` was given.

    Raises:
        UsageError: It contradicts another one.
    """
    output = asked(context)._replace(**{name: True})
    if output.quiet and output.verbose:
        raise click.UsageError("--quiet and --verbose exclude each other", context)
    context.meta[_KEY] = output


@contextmanager
def told_aside() -> Iterator[None]:
    """Run other commands: with ``--json``, what they print goes to standard error, as text."""
    context = click.get_current_context()
    before = asked(context)
    context.meta[_KEY] = before._replace(json=False)
    try:
        with redirect_stdout(sys.stderr) if before.json else nullcontext():
            yield
    finally:
        context.meta[_KEY] = before


def take_all_letters() -> None:
    """Write UTF-8 to files and pipes on every system, and escapes for what a terminal lacks."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            is_chosen = stream.isatty() or "PYTHONIOENCODING" in os.environ
            encoding = stream.encoding if is_chosen else "utf-8"
            stream.reconfigure(encoding=encoding, errors="backslashreplace")


if TYPE_CHECKING:
    _Choice = click.Choice[str]
else:
    # In older versions of click it is not generic.
    _Choice = click.Choice


class Choice(_Choice):
    """One of several words; an error names the nearest."""

    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:
        """What is wrong, and what may have been meant."""
        said = super().get_invalid_choice_message(value, ctx)
        return f"{said.removesuffix('.')}{did_you_mean(value, map(str, self.choices))}."


def echo(text: object = "", *, err: bool = False, nl: bool = True) -> None:
    """Print what was done: not with ``--quiet``, nor with ``--json`` on standard output.

    Names from files cannot move the cursor or forge other lines.
    """
    output = asked()
    if not output.quiet and (err or not output.json):
        click.echo(printable(text), err=err, nl=nl)


def answer(text: object, *, nl: bool = True) -> None:
    """Print what was asked for, such as a list: with ``--quiet`` too."""
    if not asked().json:
        click.echo(printable(text), nl=nl)


def warn(text: object) -> None:
    """Print a warning on standard error, always."""
    click.echo(f"warning: {printable(text)}", err=True)


def echo_notes(notes: Iterable[str], indent: str = "", *, err: bool = False) -> None:
    """Print notes, each once."""
    for note, count in Counter(notes).items():
        echo(f"{indent}note: {note}{f' ({count} times)' if count > 1 else ''}", err=err)


def most(rows: int) -> int:
    """The number of rows of a list to print: all with ``--verbose``."""
    return sys.maxsize if asked().verbose else rows


def gathered(rows: Iterable[tuple[Said, str]]) -> Iterator[tuple[Said, list[str]]]:
    """The names of each text, in the order in which the texts first appear.

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
    return f"{len(names)} x: {listed(names, most(_NAMED))}"


def command_line(*words: str | Path) -> str:
    """A command that can be pasted into a shell, whatever its paths are called."""
    return shell_line(str(word) for word in words)


def print_result(data: object) -> None:
    """Print data as JSON in one stable form, where ``--json`` is given."""
    if asked().json:
        print_json(data)


def print_json(data: object) -> None:
    """Print data as JSON, in one stable form."""
    click.echo(json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False))


def print_table(table: "Table") -> None:
    """Print a table that was asked for."""
    from rich.console import Console

    if not asked().json:
        Console().print(table)
