"""The command ``generate``: the room.yaml of a room from nothing."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, get_args

import click

from openrooms_usd.atomic import filling, write_text
from openrooms_usd.cli.console import echo, json_option, print_json
from openrooms_usd.description.room import RoomType
from openrooms_usd.errors import OutputError, writing

if TYPE_CHECKING:
    from openrooms_usd.generate import Generated

ROOM: Final = "room.yaml"
_MOST: Final = 100_000


@click.command()
@click.option(
    "--type", "room_type", type=click.Choice(get_args(RoomType)), required=True, metavar="TYPE",
    help="The kind of room, such as living_room.",
)  # fmt: skip
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True,
              help="Fixes everything that is drawn.")  # fmt: skip
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True, help="Output folder.")
@click.option("--count", type=click.IntRange(1, _MOST),
              help="Write this many rooms, each into a folder OUT/TYPE_SEED.")  # fmt: skip
@click.option("--area", type=click.FloatRange(2, 400), help="Floor area, square metres.")
@json_option
def generate(
    room_type: str, seed: int, out: Path, count: int | None, area: float | None, as_json: bool
) -> None:
    """Make a room from nothing: walls, openings, furniture, lamps and cameras in OUT/room.yaml.

    Equal types, seeds and areas give equal files. With --count the seeds run on from --seed.
    """
    rows = list(generate_rooms(room_type, seed, out, count=count, area=area))
    if as_json:
        print_json({"rooms": rows})
        return
    for row in rows:
        echo(f"wrote {row['room']}: {row['area']:.1f} m2, {row['objects']} objects")
    echo(f"next: orusd compose {rows[0]['room']} -o OUT")


def generate_rooms(
    room_type: str, seed: int, out: Path, *, count: int | None = None, area: float | None = None
) -> Iterator[dict[str, Any]]:
    """Write the descriptions of some rooms.

    Args:
        room_type: One of the 27.
        seed: Of the first room.
        out: The folder; made when it is missing.
        count: How many rooms, each in a folder of its own; one in ``out`` itself by default.
        area: Floor area, square metres.

    Yields:
        A row of plain data for each room, once it is written.

    Raises:
        OutputError: A folder cannot be written, or holds another room.
    """
    from openrooms_usd.generate import generate as make
    from openrooms_usd.generate import write

    for number in range(seed, seed + (count or 1)):
        folder = out if count is None else out / f"{room_type}_{number}"
        room = make(room_type, number, area)
        _write(folder, write(room))
        yield _row(room, folder / ROOM)


def _write(folder: Path, text: str) -> None:
    path = folder / ROOM
    with writing(path):
        if path.exists() and path.read_text(encoding="utf-8") != text:
            raise OutputError(
                "there is another room already", place=path,
                remedy="choose another folder, or move the file away",
            )  # fmt: skip
    with filling(folder) as inside:
        write_text(inside / ROOM, text)


def _row(room: "Generated", path: Path) -> dict[str, Any]:
    return {
        "room": str(path),
        "type": room.room_type,
        "seed": room.seed,
        "area": round(room.shell.area, 2),
        "objects": sum(len(items) for _, items in room.furnishing.groups),
    }
