"""The command ``import``: a capture becomes a folder with a room.yaml beside what was read."""

import json
import re
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final

import click

from openrooms_usd.adapters import IMPORTERS, available, find, load
from openrooms_usd.atomic import filling, write_bytes, write_text
from openrooms_usd.capture import (
    NO_OPTIONS,
    Capture,
    Importer,
    Packed,
    checked_options,
    option_paths,
)
from openrooms_usd.cli.console import json_option, print_json
from openrooms_usd.description.captured import CAPTURES
from openrooms_usd.errors import InputError, OutputError, writing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ROOM: Final = "room.yaml"
# About how many cameras a capture with photographs begins with.
_CAMERAS: Final = 5
# What a lamp in the middle of the room needs around it, metres.
_CLEAR: Final = 0.3

_TEMPLATE: Final = """\
# Made from {file} by: orusd import {kind}
# Everything may be changed; lengths are metres unless they carry a unit (240 cm), angles degrees.
name: {name}
room: misc  # such as living_room, bedroom, office: `orusd schema` lists them
seed: 0

layout:
{source}
{openings}
alignment:
{source}
  objects:
    # The scan knows no lamps: one hangs in the middle of the room.
    - {{name: ceiling_lamp, category: ceiling_lamp, at: [{x:.2f}, {y:.2f}]}}

lights:
  # What shines in by the openings: lux on level ground under the open sky.
  environment: {{from: constant, illuminance: 10000}}
  lamps:
    ceiling_lamp: {{lumen: 3000, kelvin: 4000}}

cameras:
{cameras}
"""
_SCANNED: Final = """\
# Made from {file} by: orusd import {kind}
# Everything may be changed; lengths are metres unless they carry a unit (240 cm), angles degrees.
name: {name}
room: misc  # such as living_room, bedroom, office: `orusd schema` lists them
seed: 0

layout:
{source}

alignment:
  # Every labelled instance of the scan; a folder of your own meshes: `cad: FOLDER`.
  from: scan

lights:
  # What shines in by the openings: lux on level ground under the open sky.
  environment: {{from: constant, illuminance: 10000}}

cameras:
{cameras}
"""
_SELECTED: Final = """\
  resolution: [640, 480]
  views:
    # The best of many views along the walls.
    - {from: select, count: 3}
"""
_FRAMES: Final = """\
  # The cameras of the photographs: one in {every} of {count}.
  from: capture
  every: {every}
"""
_OPENINGS: Final = """\
  # Captured: {captured}. Further ones, by the number of their wall (0 to {last}):
  # openings:
  #   - {{kind: window, wall: 0, width: 120 cm, height: 130 cm, sill: 90 cm}}
"""


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
            click.echo(f"{key:<9} {report[key]}")
        for note in report["notes"]:
            click.echo(f"note: {note}")
        click.echo(f"wrote {report['room']}; next: orusd compose {report['room']} -o OUT")

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
    try:
        asked = checked_options(kind, importer, options)
        capture = importer.read(source, asked)
        _check_usable(capture, source)
        packed = _packed(kind, importer, source, asked)
        _check_names(packed)
    except OSError as error:
        raise _unreadable(source, error) from error
    with writing(out):
        _refuse_to_replace(out, packed.contents)
    described = describe if capture.floor is not None else describe_scan
    text = described(kind, capture, packed.file, packed.options)
    parse_room(text, str(out / ROOM))
    with filling(out) as folder:
        for name, content in packed.contents.items():
            if not (out / name).exists():
                data = _bytes(content) if isinstance(content, Path) else content
                write_bytes(folder / name, data)
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
    if capture.floor is None and source.is_dir():
        raise InputError(
            "a folder of a scan is not copied",
            place=source,
            remedy="import the mesh or point cloud in it",
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
    contents = {name if key == packed.file else key: v for key, v in packed.contents.items()}
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


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: OSError) -> InputError:
    return InputError(
        f"cannot be read: {error.strerror or error}",
        place=path,
        remedy="check that it is a file, and that you may read it",
    )


def _refuse_to_replace(out: Path, contents: Mapping[str, bytes | Path]) -> None:
    remedy = "choose another folder, or move the file away"
    if (out / ROOM).exists():
        raise OutputError("there is a room already", place=out / ROOM, remedy=remedy)
    for name, content in contents.items():
        data = _bytes(content) if isinstance(content, Path) else content
        if (out / name).exists() and _bytes(out / name) != data:
            raise OutputError("another capture has that name", place=out / name, remedy=remedy)


def describe(
    kind: str, capture: Capture, file: str, options: Mapping[str, str] = NO_OPTIONS
) -> str:
    """The text of a room.yaml for a capture.

    Args:
        kind: The name of the importer.
        capture: What it read, with a floor.
        file: The captured file, relative to the description.
        options: What the importer is asked; paths are relative to the description.
    """
    assert capture.floor is not None
    x, y = _middle(capture.floor)
    kinds = [opening.kind for opening in capture.openings]
    captured = ", ".join(f"{kinds.count(k)} {k}" for k in dict.fromkeys(kinds)) or "no openings"
    return _TEMPLATE.format(
        kind=kind,
        name=re.sub(r"\W+", "_", f"room_{Path(file).stem}", flags=re.ASCII),
        file=_quoted(file),
        source=_section(kind, file, options),
        openings=_OPENINGS.format(captured=captured, last=len(capture.floor) - 1),
        x=x,
        y=y,
        cameras=_cameras(capture),
    )


def describe_scan(
    kind: str, capture: Capture, file: str, options: Mapping[str, str] = NO_OPTIONS
) -> str:
    """The text of a room.yaml for a capture of points, in which the room must be found.

    Args:
        kind: The name of the importer.
        capture: What it read, with points.
        file: The captured file, relative to the description.
        options: What the importer is asked; paths are relative to the description.
    """
    lines = ["from: scan", f"scan: {_quoted(file)}"]
    lines += [] if kind == "scan" else [f"importer: {_quoted(kind)}"]
    if options:
        pairs = (f"{_quoted(name)}: {_quoted(value)}" for name, value in options.items())
        lines.append(f"options: {{{', '.join(pairs)}}}")
    return _SCANNED.format(
        kind=kind,
        name=re.sub(r"\W+", "_", f"room_{Path(file).stem}", flags=re.ASCII),
        file=_quoted(file),
        source="\n".join(f"  {line}" for line in lines),
        cameras=_cameras(capture),
    )


def _section(kind: str, file: str, options: Mapping[str, str]) -> str:
    """The first lines of a section that comes from the capture."""
    known = kind in CAPTURES
    lines = [f"from: {kind}"] if known else ["from: capture", f"importer: {_quoted(kind)}"]
    lines.append(f"file: {_quoted(file)}")
    if options:
        pairs = (f"{_quoted(name)}: {_quoted(value)}" for name, value in options.items())
        lines.append(f"options: {{{', '.join(pairs)}}}")
    return "\n".join(f"  {line}" for line in lines)


def _quoted(text: str) -> str:
    """A JSON string, which is a YAML string."""
    return json.dumps(text, ensure_ascii=False)


def _cameras(capture: Capture) -> str:
    count = len(capture.frames)
    if not count:
        return _SELECTED.rstrip("\n")
    return _FRAMES.format(count=count, every=max(1, count // _CAMERAS)).rstrip("\n")


def _middle(floor: "NDArray[np.float64]") -> tuple[float, float]:
    """The centroid of a floor, or where it is widest if the centroid is not well inside."""
    import shapely

    polygon = shapely.Polygon(floor)
    centroid = polygon.centroid
    if polygon.contains(centroid) and polygon.exterior.distance(centroid) > _CLEAR:
        return centroid.x, centroid.y
    widest = shapely.maximum_inscribed_circle(polygon, tolerance=0.01)
    x, y = shapely.get_coordinates(widest)[0]
    return float(x), float(y)


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
