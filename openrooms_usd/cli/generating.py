"""The command ``generate``: the room.yaml of a room from nothing."""

from pathlib import Path
from typing import TYPE_CHECKING, Final, get_args

import click

from openrooms_usd.cli.bar import progress_bar
from openrooms_usd.cli.command import Command, folder_option
from openrooms_usd.cli.console import Choice, command_line, echo, print_result
from openrooms_usd.description.room import RoomType
from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.progress import Counted

if TYPE_CHECKING:
    from openrooms_usd.generation.folders import GeneratedFile

_MOST: Final = 100_000


@click.command(cls=Command, example="orusd generate --type bedroom --seed 1 -o bedroom")
@click.option(
    "--type",
    "room_type",
    type=Choice(get_args(RoomType)),
    required=True,
    metavar="TYPE",
    help=f"The kind of room: {', '.join(get_args(RoomType))}.",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**63 - 1),
    default=0,
    show_default=True,
    help="Fixes everything that is drawn.",
)
@folder_option
@click.option(
    "--count",
    type=click.IntRange(1, _MOST),
    help="Write this many rooms, each into a folder OUT/TYPE_SEED.",
)
@click.option("--area", type=click.FloatRange(2, 400), help="Floor area, square metres.")
@click.option(
    "--style",
    type=Choice(get_args(InteriorStyle)),
    help="What furniture, materials and colours go together; drawn by default.",
)
@click.option(
    "--clutter",
    type=click.IntRange(0, 3),
    default=2,
    show_default=True,
    help="How much lies about: 0 nothing, 1 tidy, 2 lived in, 3 messy.",
)
def generate(
    room_type: str,
    seed: int,
    out: Path,
    count: int | None,
    area: float | None,
    style: InteriorStyle | None,
    clutter: int,
) -> None:
    """Generate a room: walls, openings, furniture, lamps and cameras in OUT/room.yaml.

    Equal types, seeds, areas, styles and clutter give equal files. With --count the seeds run on
    from --seed.
    """
    from openrooms_usd.generation.folders import generate_rooms

    rooms: list[GeneratedFile] = []
    with progress_bar("generating") as progress:
        for room in generate_rooms(
            room_type, seed, out, count=count, area=area, style=style, clutter=clutter
        ):
            rooms.append(room)
            what = Counted(room.file.parent.name, len(rooms), count or 1)
            progress(what, what.number / what.total)
    print_result({"rooms": [room.as_dict() for room in rooms]})
    for room in rooms:
        echo(f"wrote {room.file}: {room.made.shell.area:.1f} m2, {room.objects} objects")
    echo(f"next: {command_line('orusd', 'compose', rooms[0].file, '-o', 'out')}")
