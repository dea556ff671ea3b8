"""The options of commands that render: which renderer, and what is asked of it."""

import functools
from collections.abc import Callable
from typing import Any

import click

Command = Callable[..., Any]


def renderer_options(**shorthands: str) -> Callable[[Command], Command]:
    """Options that reach a command as ``renderer``, a name, and ``options``, values by name.

    Args:
        shorthands: Options of renderers that have a flag of their own: its help, by name.
    """

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def with_options(*args: Any, pairs: tuple[tuple[str, str], ...], **given: Any) -> Any:
            short = {name: given.pop(name) for name in shorthands}
            said = {name: value for name, value in short.items() if value is not None}
            return command(*args, options=said | dict(pairs), **given)

        found: Command = with_options
        for name, text in reversed(shorthands.items()):
            found = click.option(f"--{name}", help=f"{text} Short for --option {name}=…")(found)
        found = click.option(
            "--option", "pairs", multiple=True, callback=pairs_of, metavar="NAME=VALUE",
            help="Something that this renderer can be asked for. Repeatable.",
        )(found)  # fmt: skip
        return click.option(
            "--renderer", default="mitsuba", show_default=True,
            help="mitsuba, preview (quick, without light), or another that is installed.",
        )(found)  # fmt: skip

    return decorate


def pairs_of(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> tuple[tuple[str, str], ...]:
    """Names and values, from ``variant=llvm``; the last of a name counts."""
    found = []
    for text in values:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise click.BadParameter(f"{text!r} is not NAME=VALUE", ctx, param)
        found.append((name, value))
    return tuple(found)
