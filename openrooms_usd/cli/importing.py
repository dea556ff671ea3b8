"""The command ``import``: a capture becomes a folder with a room.yaml beside what was read."""

import filecmp
import os
import re
import shutil
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final

import click

from openrooms_usd.adapters import IMPORTERS, available, find, load
from openrooms_usd.atomic import filling, replacing, write_bytes, write_text
from openrooms_usd.capture import (
    NO_OPTIONS,
    Capture,
    Importer,
    Packed,
    checked_options,
    option_paths,
)
from openrooms_usd.claims import locked
from openrooms_usd.cli.captured_text import describe, describe_scan
from openrooms_usd.cli.console import echo, json_option, print_json
from openrooms_usd.errors import InputError, OutputError, writing
from openrooms_usd.untrusted import check_path, opened

if TYPE_CHECKING:
    pass

ROOM: Final = "room.yaml"


class ImporterGroup(click.Group):
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

    @click.command(name=kind, short_help=f"Import a {kind} capture.")
    @click.argument("source", type=click.Path(path_type=Path))
    @click.option(
        "-o", "--out", type=click.Path(path_type=Path), required=True, help="Folder to write to."
    )
    @json_option
    def command(source: Path, out: Path, as_json: bool, **options: str | None) -> None:
        """Check that SOURCE reads, copy it into a folder and describe the room in room.yaml."""
        given = {name: options[_field(name)] for name in importer.options}
        capture = import_capture(kind, source, out, {n: v for n, v in given.items() if v})
        report = summary(capture, out)
        if as_json:
            print_json(report)
            return
        for key in ("walls", "openings", "objects", "models", "frames", "points"):
            echo(f"{key:<9} {report[key]}")
        for note in report["notes"]:
            echo(f"note: {note}")
        echo(f"wrote {report['room']}; next: orusd compose {report['room']} -o OUT")

    for name, text in importer.options.items():
        metavar = "PATH" if name in option_paths(importer) else "TEXT"
        flag = click.Option([f"--{name}", _field(name)], metavar=metavar, help=text)
        command.params.append(flag)
    return command


def _field(name: str) -> str:
    """An option as a parameter, which no parameter of the command itself can be."""
    return f"option_{name}"


def import_capture(
    kind: str, source: Path, out: Path, options: Mapping[str, str] = NO_OPTIONS
) -> Capture:
    """Read a capture, copy what a room needs of it into a folder, and describe the room there.

    Args:
        kind: The name of the importer.
        source: What it reads.
        out: The folder; made when it is missing.
        options: What is asked of the importer; paths begin in the current folder.

    Returns:
        The capture.

    Raises:
        InputError: The source cannot be read, or has no usable floor.
        OutputError: The folder cannot be written, or holds another room or capture.
    """
    from openrooms_usd.description import parse_room

    importer: Importer = load(IMPORTERS, kind)
    check_path(source)
    try:
        asked = checked_options(kind, importer, options)
        capture = importer.read(source, asked)
        _check_usable(capture, source)
        packed = _packed(kind, importer, source, asked)
        _check_names(packed)
    except OSError as error:
        raise _unreadable(source, error) from error
    described = describe if capture.floor is not None else describe_scan
    text = described(kind, capture, packed.file, packed.options)
    parse_room(text, str(out / ROOM))
    with locked(out):
        with writing(out):
            _refuse_to_replace(out, packed.contents)
        with filling(out) as folder:
            for name, content in packed.contents.items():
                if not os.path.lexists(out / name):
                    _copy(content, folder / name)
            write_text(folder / ROOM, text)
    return capture


def _check_usable(capture: Capture, source: Path) -> None:
    """Refuse what no room can be made of."""
    if capture.floor is None and capture.cloud is None:
        raise InputError(
            "the capture has no floor, and no walls that enclose one",
            place=source,
            remedy=capture.remedy,
        )


def _packed(kind: str, importer: Importer, source: Path, options: Mapping[str, str]) -> Packed:
    """What of a capture is copied: what its importer says, or else the file as it is."""
    pack = getattr(importer, "pack", None)
    if pack is not None:
        packed: Packed = pack(source, options)
    else:
        packed = Packed(source.name, {source.name: source}, options)
    if packed.file.isprintable() and packed.file != ROOM:
        return packed
    name = f"{kind}{Path(packed.file).suffix}"
    # The file itself, or the folder that the files lie in.
    own = re.compile(re.escape(packed.file) + "(?=/|$)")
    contents = {own.sub(name, key, count=1): v for key, v in packed.contents.items()}
    return Packed(name, contents, packed.options)


def _check_names(packed: Packed) -> None:
    """Refuse files that would lie elsewhere, or where the description comes."""
    for name, content in packed.contents.items():
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts or path == PurePosixPath(ROOM):
            raise InputError(
                f"a file of the capture cannot be copied as {name!r}",
                place=content if isinstance(content, Path) else None,
                remedy="give it another name",
            )


def _copy(content: bytes | Path, target: Path) -> None:
    if isinstance(content, bytes):
        write_bytes(target, content)
        return
    with opened(content, "frames") as source, replacing(target) as path, path.open("wb") as copy:
        shutil.copyfileobj(source, copy)


def _unreadable(path: Path, error: OSError) -> InputError:
    return InputError(
        f"cannot be read: {error.strerror or error}",
        place=path,
        remedy="check that it is a file, and that you may read it",
    )


def _refuse_to_replace(out: Path, contents: Mapping[str, bytes | Path]) -> None:
    remedy = "choose another folder, or move the file away"
    if os.path.lexists(out / ROOM):
        raise OutputError("there is a room already", place=out / ROOM, remedy=remedy)
    for name, content in contents.items():
        if os.path.lexists(out / name) and not _equal(content, out / name):
            raise OutputError("another capture has that name", place=out / name, remedy=remedy)


def _equal(content: bytes | Path, target: Path) -> bool:
    if isinstance(content, bytes):
        return target.is_file() and target.read_bytes() == content
    return target.is_file() and filecmp.cmp(content, target, shallow=False)


def summary(capture: Capture, out: Path) -> dict[str, Any]:
    """What was imported, as plain data."""
    return {
        "room": str(out / ROOM),
        "walls": 0 if capture.floor is None else len(capture.floor),
        "openings": len(capture.openings),
        "objects": len(capture.boxes) + len(capture.models),
        "models": sum(model.file is not None for model in capture.models),
        "frames": len(capture.frames),
        "points": 0 if capture.cloud is None else len(capture.cloud),
        "height": capture.height,
        "notes": list(capture.notes),
    }
