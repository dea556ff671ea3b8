"""What all commands share: three options, help in sections with an example, and former names."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from openrooms_usd.cli.console import echo_notes, remember
from openrooms_usd.spelling import did_you_mean

Function = TypeVar("Function", bound=Callable[..., Any])

# Where click keeps what is to be said of former names.
_NOTES: Final = "openrooms_usd.former"
USUAL: Final = "Options"
"""The section of options that have no other."""

# Characters of a first sentence at most.
_SENTENCE: Final = 200
_GLOBAL: Final = "Global options"
_GLOBAL_FLAGS: Final = {
    ("-q", "--quiet"): "Print only what was asked for, warnings and errors.",
    ("-v", "--verbose"): "Print every note and name in full, and the time of each step.",
    ("--json",): "Print the result as one JSON document, and nothing else on standard output.",
}


folder_option: Final = click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    metavar="DIR",
    help="Output folder.",
)
"""Where a command writes several files."""


def section(title: str, *options: Callable[[Any], Any]) -> Callable[[Function], Function]:
    """Options that ``--help`` lists under a title of their own.

    Args:
        title: Of the section.
        options: What `click.option` returns, in the order of the list.
    """

    def decorate(function: Function) -> Function:
        for option in reversed(options):
            function = option(function)
            function.__click_params__[-1].section = title  # type: ignore[attr-defined]
        return function

    return decorate


class Command(click.Command):
    """A command with ``--quiet``, ``--verbose`` and ``--json``.

    Args:
        example: A command line that ``--help`` shows.
        former: The present name of each option, or command of a group, that had another one; or
            what chooses it by the option's value, empty where none was given.
    """

    def __init__(
        self,
        *args: Any,
        example: str | None = None,
        former: Mapping[str, str | Callable[[str], str]] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self.example, self.former = example, dict(former or {})
        self.params += [
            click.Option(
                flags,
                is_flag=True,
                expose_value=False,
                is_eager=True,
                callback=_remember,
                help=text,
            )
            for flags, text in _GLOBAL_FLAGS.items()
        ]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the words of a command line, with former names of options as the present ones."""
        end = args.index("--") if "--" in args else len(args)
        words = zip(args[:end], [*args[1:end], ""], strict=False)
        present = [self._present(ctx, word, following) for word, following in words]
        return super().parse_args(ctx, present + args[end:])

    def _present(self, ctx: click.Context, word: str, following: str) -> str:
        name, equals, value = word.partition("=")
        if not name.startswith("-") or name not in self.former:
            return word
        present = self.former[name]
        if callable(present):
            present = present(value if equals or following.startswith("-") else following)
        note_former(ctx, name, present)
        return f"{present}{equals}{value}"

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        if not isinstance(self, click.Group):
            echo_notes(ctx.meta.pop(_NOTES, ()), err=True)
        return super().invoke(ctx)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options in sections, and the example."""
        rows: dict[str, list[tuple[str, str]]] = {USUAL: []}
        shared: list[tuple[str, str]] = []
        for param in self.get_params(ctx):
            record = param.get_help_record(ctx)
            if record is None or isinstance(param, click.Argument):
                continue
            is_shared = not param.expose_value
            title = getattr(param, "section", USUAL)
            (shared if is_shared else rows.setdefault(title, [])).append(record)
        for title, records in (*rows.items(), (_GLOBAL, shared)):
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)
        if self.example:
            with formatter.section("Example"):
                formatter.write(f"{'':{formatter.current_indent}}{self.example}\n")


class Group(Command, click.Group):
    """A group of commands; the error for an unknown one suggests the nearest."""

    command_class = Command

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names in the order in which the commands are made."""
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the first sentence of each command, whole."""
        found = ((name, self.get_command(ctx, name)) for name in self.list_commands(ctx))
        with formatter.section("Commands"):
            formatter.write_dl(
                [
                    (name, command.get_short_help_str(_SENTENCE))
                    for name, command in found
                    if command
                ]
            )

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands, then the options."""
        self.format_commands(ctx, formatter)
        super().format_options(ctx, formatter)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command, also by its former name.

        Raises:
            UsageError: There is none of that name.
        """
        present = self.former.get(args[0])
        if isinstance(present, str):
            note_former(ctx, args[0], present)
            args = [present, *args[1:]]
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            if args[0].startswith("-"):
                raise
            hint = did_you_mean(args[0], self.list_commands(ctx))
            raise click.UsageError(f"No such command {args[0]!r}{hint}.", ctx) from error


def note_former(ctx: click.Context, former: str, present: str) -> None:
    """Keep a note until all words are read: ``--quiet`` may be among them.

    Args:
        ctx: Where it was found.
        former: The name that was given.
        present: The name it has now.
    """
    ctx.meta.setdefault(_NOTES, []).append(f"`{former}` is called `{present}` now")


def _remember(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value and param.name:
        remember(ctx, param.name)
