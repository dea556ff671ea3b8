"""The commands ``init``, ``schema``, ``doctor`` and ``completion``."""

import sys
from pathlib import Path

import click

from openrooms_usd.cli.console import Choice, command_line, echo, json_option, print_json


@click.command()
@click.argument("folder", type=click.Path(path_type=Path), metavar="DIR")
@json_option
def init(folder: Path, as_json: bool) -> None:
    """Write DIR/room.yaml, a small living room to start from, and its JSON Schema beside it."""
    from openrooms_usd.demo import write_starter

    description, rules = write_starter(folder)
    if as_json:
        print_json({"description": str(description), "schema": str(rules)})
        return
    echo(f"wrote {description}")
    echo(f"next:  {command_line('orusd', 'compose', description, '-o', folder / 'out')}")


@click.command()
@click.argument("name", type=Choice(["room", "dataset"]), default="room")
def schema(name: str) -> None:
    """Print the JSON Schema of room.yaml, or of dataset.yaml (draft 2020-12)."""
    from openrooms_usd.description.schema import schema_text

    echo(schema_text(name), nl=False)


@click.command()
@json_option
def doctor(as_json: bool) -> None:
    """Say what this machine can do, what it lacks, and what to do about it.

    Leaves with code 1 when something is missing that the toolkit cannot do without.
    """
    from openrooms_usd.doctor import diagnose

    found = diagnose()
    if as_json:
        print_json(found.as_dict())
    else:
        _print_table("system", found.system)
        _print_table("packages", {k: v or "not installed" for k, v in found.packages.items()})
        _print_table("extras", found.extras)
        _print_table("ray casting", {"caster": found.ray_caster or "none"})
        _print_table("adapters", {k: ", ".join(v) or "none" for k, v in found.adapters.items()})
        for name, states in found.renderers.items():
            _print_table(f"renderer {name}", states)
        for remedy in found.remedies:
            echo(f"remedy: {remedy}")
    sys.exit(0 if found.healthy else 1)


def _print_table(title: str, rows: dict[str, str]) -> None:
    echo(title)
    for key, value in rows.items():
        echo(f"  {key:<16} {value}")


@click.command()
@click.argument("shell", type=Choice(["bash", "zsh", "fish"]))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print what completes commands and options in a shell.

    For bash, ~/.bashrc has a line: eval "$(orusd completion bash)". docs/howto/installing.md
    has those of other shells.
    """
    from click.shell_completion import get_completion_class

    script = get_completion_class(shell)
    assert script is not None
    echo(script(context.find_root().command, {}, "orusd", "_ORUSD_COMPLETE").source(), nl=False)
