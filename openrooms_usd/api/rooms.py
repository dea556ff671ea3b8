"""Ways to a room: from nothing, from a file or plain data, from a capture; and into a file."""

from collections.abc import Mapping
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

from openrooms_usd.api.given import AnyPath, path_of, room_of

if TYPE_CHECKING:
    from openrooms_usd.description.room import Room, RoomType
    from openrooms_usd.description.styles import InteriorStyle
    from openrooms_usd.importing import ImportedRoom


def generate(
    room_type: "RoomType",
    seed: int = 0,
    *,
    area: float | None = None,
    style: "InteriorStyle | None" = None,
    clutter: int = 2,
) -> "Room":
    """Make a room from nothing: walls, openings, furniture, lamps and cameras.

    Equal arguments give equal rooms. Nothing is written.

    Args:
        room_type: Such as ``living_room``; one of 27.
        seed: Fixes everything that is drawn.
        area: Of the floor, square metres; drawn by default.
        style: Such as ``mid_century``: what furniture, materials and colours go together; drawn by
            default.
        clutter: How much lies about: 0 nothing, 1 tidy, 2 lived in, 3 messy.

    Returns:
        The room, to be composed, saved or changed.

    Raises:
        InputError: There is no such room type, style or seed, or no room of that area can be made.
    """
    from openrooms_usd.description import parse_room
    from openrooms_usd.errors import InputError
    from openrooms_usd.generate import generate as make
    from openrooms_usd.generate import write

    if not isinstance(seed, Integral) or not 0 <= seed < 2**63:
        remedy = "give a whole number of at least 0"
        raise InputError(f"{seed!r} is no seed", place="seed", remedy=remedy)
    made = make(room_type, int(seed), area, style, clutter)
    return parse_room(write(made), f"generated {room_type}")


def load(description: "Room | Mapping[str, Any] | AnyPath") -> "Room":
    """Read a room and check it.

    Args:
        description: A ``room.yaml``, a folder that holds one, or plain data as it would hold.

    Returns:
        The room, with every default filled in.

    Raises:
        InputError: The file is missing or cannot be read.
        DescriptionError: It has mistakes; the message lists all with their places.
    """
    return room_of(description)


def save(room: "Room | Mapping[str, Any]", file: AnyPath) -> Path:
    """Write a room as a ``room.yaml`` that `load` reads back as the same room.

    The names of files in it are written as they are: they begin in the folder of ``file`` then.

    Args:
        room: The room.
        file: The file to write; one that is there is replaced.

    Returns:
        The file.

    Raises:
        DescriptionError: The room has mistakes.
        OutputError: The file cannot be written.
    """
    from openrooms_usd.atomic import making, write_text
    from openrooms_usd.description import dump_room

    path, text = path_of(file), dump_room(room_of(room))
    with making(path.parent):
        write_text(path, text)
    return path


def import_capture(
    source: AnyPath, out: AnyPath, *, kind: str, options: Mapping[str, str] | None = None
) -> "ImportedRoom":
    """Turn a capture into a room: a folder with a ``room.yaml`` and what it needs of the capture.

    Args:
        source: The captured file or folder.
        out: The folder to write; made when it is missing.
        kind: The importer, such as ``roomplan`` or ``scan``: docs/captures.md lists them.
        options: What is asked of the importer, as `orusd import KIND --help` lists it.

    Returns:
        ``.room``, ``.file``, what was read (``.capture``) and ``.notes`` of what was guessed.

    Raises:
        InputError: There is no such importer or option, or the source cannot be read.
        OutputError: The folder cannot be written, or holds another room or capture.
        MissingPackageError: The importer needs a package that is not installed.
    """
    from openrooms_usd.importing import import_capture as read

    return read(kind, path_of(source), path_of(out), options or {})


def copy_example(folder: AnyPath) -> Path:
    """Copy the bundled example, a living room with a sky, into a folder.

    Args:
        folder: Made when it is missing; an example that is there already is kept.

    Returns:
        Its ``room.yaml``.

    Raises:
        OutputError: The folder cannot be written.
    """
    from openrooms_usd.demo import copy_example as copy

    return copy(path_of(folder))
