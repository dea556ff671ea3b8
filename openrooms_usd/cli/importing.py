"""The command ``import``: a capture becomes a folder with a room.yaml beside what was read."""

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from openrooms_usd.adapters import IMPORTERS, available, find, load
from openrooms_usd.atomic import filling, write_bytes, write_text
from openrooms_usd.capture import Capture
from openrooms_usd.cli.console import json_option, print_json
from openrooms_usd.errors import InputError, OutputError, writing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ROOM: Final = "room.yaml"
# What a lamp in the middle of the room needs around it, metres.
_CLEAR: Final = 0.3

_TEMPLATE: Final = """\
# Made from {file} by: orusd import {kind}
# Everything may be changed; lengths are metres unless they carry a unit (240 cm), angles degrees.
name: {name}
room: misc  # such as living_room, bedroom, office: `orusd schema` lists them
seed: 0

layout:
  from: {kind}
  file: {file}
{openings}
alignment:
  from: {kind}
  file: {file}
  objects:
    # The scan knows no lamps: one hangs in the middle of the room.
    - {{name: ceiling_lamp, category: ceiling_lamp, at: [{x:.2f}, {y:.2f}]}}

lights:
  # What shines in by the openings: lux on level ground under the open sky.
  environment: {{from: constant, illuminance: 10000}}
  lamps:
    ceiling_lamp: {{lumen: 3000, kelvin: 4000}}

cameras:
  resolution: [640, 480]
  views:
    # The best of many views along the walls.
    - {{from: select, count: 3}}
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
    @click.command(name=kind, short_help=f"Import a {kind} capture.")
    @click.argument("source", type=click.Path(path_type=Path))
    @click.option(
        "-o", "--out", type=click.Path(path_type=Path), required=True, help="Folder to write to."
    )
    @json_option
    def command(source: Path, out: Path, as_json: bool) -> None:
        """Check that SOURCE reads, copy it into a folder and describe the room in room.yaml."""
        capture = import_capture(kind, source, out)
        report = summary(capture, out)
        if as_json:
            print_json(report)
            return
        for key in ("walls", "openings", "objects"):
            click.echo(f"{key:<9} {report[key]}")
        for note in report["notes"]:
            click.echo(f"note: {note}")
        click.echo(f"wrote {report['room']}; next: orusd compose {report['room']} -o OUT")

    return command


def import_capture(kind: str, source: Path, out: Path) -> Capture:
    """Read a capture, copy it into a folder as it is, and write a room.yaml beside it.

    Args:
        kind: The name of the importer.
        source: What it reads.
        out: The folder; made when it is missing.

    Returns:
        The capture.

    Raises:
        InputError: The source cannot be read, or has no usable floor.
        OutputError: The folder cannot be written, or holds another room or capture.
    """
    from openrooms_usd.description import parse_room

    try:
        capture: Capture = load(IMPORTERS, kind).read(source)
    except OSError as error:
        raise _unreadable(source, error) from error
    if capture.floor is None:
        raise InputError(
            "the capture has no floor, and no walls that enclose one",
            place=source,
            remedy="scan the room again, so that its walls close",
        )
    data = _bytes(source)
    keep = source.name.isprintable() and source.name != ROOM
    copy = out / (source.name if keep else f"{kind}{source.suffix}")
    with writing(out):
        _refuse_to_replace(copy, data)
    text = describe(kind, capture, copy.name)
    parse_room(text, str(out / ROOM))
    with filling(out) as folder:
        if not copy.exists():
            write_bytes(folder / copy.name, data)
        write_text(folder / ROOM, text)
    return capture


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


def _refuse_to_replace(copy: Path, data: bytes) -> None:
    remedy = "choose another folder, or move the file away"
    room = copy.with_name(ROOM)
    if room.exists():
        raise OutputError("there is a room already", place=room, remedy=remedy)
    if copy.exists() and _bytes(copy) != data:
        raise OutputError("another capture has that name", place=copy, remedy=remedy)


def describe(kind: str, capture: Capture, file: str) -> str:
    """The text of a room.yaml for a capture.

    Args:
        kind: The name of the importer.
        capture: What it read, with a floor.
        file: The captured file, relative to the description.
    """
    assert capture.floor is not None
    x, y = _middle(capture.floor)
    kinds = [opening.kind for opening in capture.openings]
    captured = ", ".join(f"{kinds.count(k)} {k}" for k in dict.fromkeys(kinds)) or "no openings"
    return _TEMPLATE.format(
        kind=kind,
        name=re.sub(r"\W+", "_", f"room_{Path(file).stem}", flags=re.ASCII),
        file=json.dumps(file, ensure_ascii=False),  # a JSON string is a YAML string
        openings=_OPENINGS.format(captured=captured, last=len(capture.floor) - 1),
        x=x,
        y=y,
    )


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
        "objects": len(capture.boxes),
        "height": capture.height,
        "notes": list(capture.notes),
    }
