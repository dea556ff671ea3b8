"""The commands ``init``, ``schema``, ``doctor`` and ``completion``."""

import json
import sys
from pathlib import Path

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command
from openrooms_usd.cli.console import Choice, answer, command_line, echo, print_result


@click.command(cls=Command, example="orusd init my_room")
@click.argument("folder", type=click.Path(path_type=Path), metavar="DIR")
def init(folder: Path) -> None:
    """Write DIR/room.yaml, a small living room to start from, and its JSON Schema beside it."""
    from openrooms_usd.demo import write_starter

    description, rules = write_starter(folder)
    print_result({"description": str(description), "schema": str(rules)})
    echo(f"wrote {description}")
    echo(f"next:  {command_line('orusd', 'compose', description, '-o', 'out')}")


@click.command(cls=Command, example="orusd schema room")
@click.argument("name", type=Choice(["room", "dataset"]), default="room")
def schema(name: str) -> None:
    """Print the JSON Schema of room.yaml, or of dataset.yaml (draft 2020-12)."""
    from openrooms_usd.description.schema import schema_text

    print_result(json.loads(schema_text(name)))
    answer(schema_text(name), nl=False)


@click.command(cls=Command, example="orusd doctor")
def doctor() -> None:
    """Say what this machine can do, what it lacks, and what to do about it.

    Leaves with code 1 when something is missing that the toolkit cannot do without.
    """
    from openrooms_usd.doctor import diagnose

    with progress_bar("trying"):
        found = diagnose()
    print_result(found.as_dict())
    _print_table("system", found.system)
    _print_table("packages", {k: v or "not installed" for k, v in found.packages.items()})
    _print_table("extras", found.extras)
    _print_table("ray casting", {"caster": found.ray_caster or "none"})
    _print_table("adapters", {k: ", ".join(v) or "none" for k, v in found.adapters.items()})
    for name, states in found.renderers.items():
        _print_table(f"renderer {name}", states)
    for remedy in found.remedies:
        answer(f"remedy: {remedy}")
    sys.exit(0 if found.healthy else 1)


def _print_table(title: str, rows: dict[str, str]) -> None:
    answer(title)
    for key, value in rows.items():
        answer(f"  {key:<16} {value}")


@click.command(cls=Command, example="orusd completion bash")
@click.argument("shell", type=Choice(["bash", "zsh", "fish"]))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print what completes commands and options in a shell.

    For bash, ~/.bashrc has a line: eval "$(orusd completion bash)". docs/howto/installing.md
    has those of other shells.
    """
    from click.shell_completion import get_completion_class

    found = get_completion_class(shell)
    assert found is not None
    script = found(context.find_root().command, {}, "orusd", "_ORUSD_COMPLETE").source()
    print_result({"shell": shell, "script": script})
    answer(script, nl=False)
