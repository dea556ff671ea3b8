"""The command ``import``: a capture becomes a folder with a room.yaml beside what was read."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from openrooms_usd.adapters import IMPORTERS, available, find, load
from openrooms_usd.capture import Importer, option_paths
from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command, Group, folder_option
from openrooms_usd.cli.console import command_line, echo, echo_notes, print_result

if TYPE_CHECKING:
    from openrooms_usd.importing import ImportedRoom


class ImporterGroup(Group):
    """A group with one command for each importer that is installed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names of the importers; none of them is imported."""
        return list(available(IMPORTERS))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of one importer.

        Raises:
            InputError: None has that name.
        """
        return _command(find(IMPORTERS, cmd_name).name)


@click.group(name="import", cls=ImporterGroup)
def import_() -> None:
    """Turn a capture into a room.yaml, and keep what was read beside it."""


def _command(kind: str) -> click.Command:
    importer: Importer = load(IMPORTERS, kind)

    @click.command(
        name=kind,
        cls=Command,
        short_help=_about(importer) or kind,
        example=f"orusd import {kind} CAPTURE -o my_room",
        former={
            f"--{name}": _flag(name) for name in importer.options if f"--{name}" != _flag(name)
        },
    )
    @click.argument("source", type=click.Path(path_type=Path))
    @folder_option
    def command(source: Path, out: Path, **options: str | None) -> None:
        """Check that SOURCE reads, copy it into a folder and describe the room in room.yaml."""
        from openrooms_usd.importing import import_capture

        given = {name: options[_field(name)] for name in importer.options}
        with progress_bar("reading") as progress:
            imported = import_capture(
                kind, source, out, {n: v for n, v in given.items() if v}, progress
            )
        print_result(imported.as_dict())
        for line in _lines_of(imported):
            echo(line)
        echo_notes(imported.notes)
        following = command_line("orusd", "compose", imported.file, "-o", "out")
        is_scan = imported.capture.floor is None
        purpose = ", which finds walls, openings and furniture" if is_scan else ""
        echo(f"wrote {imported.file}; next: {following}{purpose}")

    for name, text in importer.options.items():
        metavar = "PATH" if name in option_paths(importer) else "TEXT"
        flag = click.Option([_flag(name), _field(name)], metavar=metavar, help=text)
        command.params.append(flag)
    return command


def _lines_of(imported: "ImportedRoom") -> Iterator[str]:
    """What was read, a line each: of points their extent and what each of them has."""
    found, cloud = imported.counts, imported.capture.cloud
    for what, count in found.items():
        if count or cloud is None:
            yield f"{what:<9} {count}"
    if cloud is None:
        return
    import numpy as np

    from openrooms_usd.scan.points.mainpart import main_part

    size = " x ".join(f"{length:.1f}" for length in np.ptp(main_part(cloud).points, axis=0))
    told = ("colors", "normals", "label", "instance")
    has = [word for word in told if getattr(cloud, word) is not None]
    yield f"size      {size} m"
    yield f"each has  {', '.join(has) or 'its place alone'}"


def _about(importer: Importer) -> str:
    """What an importer reads, in its own words."""
    sentence = (type(importer).__doc__ or "").strip().partition("\n")[0].replace("``", "")
    return sentence.replace("Reads ", "Read ", 1)


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _field(name: str) -> str:
    """An option as a parameter, which no parameter of the command itself can be."""
    return f"option_{name}"
