"""Ways to a room: empty, from nothing, from a file or plain data, from a capture."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any

from openrooms_usd.api.given import AnyPath, path_of, room_of

if TYPE_CHECKING:
    from openrooms_usd.api.room import Point, Room
    from openrooms_usd.description.room import RoomType
    from openrooms_usd.description.styles import InteriorStyle
    from openrooms_usd.importing import ImportedRoom


def new_room(
    room_type: "RoomType" = "misc",
    *,
    width: float | str = 5.0,
    depth: float | str = 4.0,
    height: float | str | None = None,
    polygon: "Sequence[Point] | None" = None,
    seed: int = 0,
    style: "InteriorStyle | None" = None,
    physics: bool = False,
) -> "Room":
    """An empty room, to be built step by step.

    Args:
        room_type: Such as ``office``; chooses materials and other defaults.
        width: Along x, metres. The corners are (0, 0), (width, 0), (width, depth), (0, depth). So
            wall 0 lies at y = 0, wall 1 at x = width, wall 2 at y = depth, wall 3 at x = 0.
        depth: Along y, metres.
        height: Floor to ceiling, metres; as usual by default.
        polygon: Inner corners in order in place of a rectangle, metres.
        seed: Fixes everything that is drawn.
        style: What furniture, materials and colours go together.
        physics: Whether things weigh, collide and move.

    Returns:
        The room: ``room.add("bed", at=(2, 1))``, ``room.add_window(wall=0)``,
        ``room.compose("out")``.

    Raises:
        DescriptionError: There is no such room type or style, or a value is out of range.
    """
    from openrooms_usd.api.room import Room, given_of
    from openrooms_usd.description import room_of as checked

    corners = polygon or [(0, 0), (width, 0), (width, depth), (0, depth)]
    layout = given_of(polygon=[list(corner) for corner in corners], height=height)
    said = given_of(room=room_type, seed=seed, style=style, physics={} if physics else None)
    return Room.of(checked({**said, "layout": layout}))


def generate(
    room_type: "RoomType",
    seed: int = 0,
    *,
    area: float | None = None,
    style: "InteriorStyle | None" = None,
    clutter: int = 2,
) -> "Room":
    """Generate a room: walls, openings, furniture, lamps and cameras.

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
    from openrooms_usd.api.room import Room
    from openrooms_usd.description import parse_room
    from openrooms_usd.errors import InputError
    from openrooms_usd.generation import generate as make
    from openrooms_usd.generation import write

    if not isinstance(seed, Integral) or not 0 <= seed < 2**63:
        remedy = "give a whole number such as 7"
        raise InputError(
            f"must be a whole number of at least 0, got {seed!r}", place="seed", remedy=remedy
        )
    if not isinstance(clutter, Integral) or not 0 <= clutter <= 3:
        remedy = "give 0 (nothing), 1 (tidy), 2 (lived in) or 3 (messy)"
        raise InputError(f"{clutter!r} is not an amount", place="clutter", remedy=remedy)
    if area is not None and not isinstance(area, Real):
        remedy = "give square metres as a number, such as 14.5"
        raise InputError(f"{area!r} is not a number", place="area", remedy=remedy)
    made = make(room_type, int(seed), area, style, clutter)
    return Room.of(parse_room(write(made), f"generated {room_type}"))


def load_room(description: "Room | Mapping[str, Any] | AnyPath") -> "Room":
    """Read a room and check it.

    Args:
        description: A ``room.yaml``, a folder that holds one, or plain data as it would hold.

    Returns:
        The room, with every default filled in; changing it changes no file.

    Raises:
        InputError: The file is missing or cannot be read.
        DescriptionError: It has mistakes; the message lists all with their places.
    """
    from openrooms_usd.api.room import Room

    return Room.of(room_of(description))


def import_capture(
    source: AnyPath, out: AnyPath, *, kind: str, options: Mapping[str, str] | None = None
) -> "ImportedRoom":
    """Turn a capture into a room: a folder with a ``room.yaml`` and what it needs of the capture.

    Args:
        source: The captured file or folder.
        out: The folder to write; made when it is missing.
        kind: The importer, such as ``roomplan`` or ``scan``: docs/howto/captures.md lists them.
        options: What is asked of the importer, as `orusd import KIND --help` lists it.

    Returns:
        ``.room``, ``.file``, what was read (``.capture``) and ``.notes`` of what was guessed.

    Raises:
        InputError: There is no such importer or option, or the source cannot be read.
        OutputError: The folder cannot be written, or holds another room or capture.
        MissingPackageError: The importer needs a package that is not installed.
    """
    from openrooms_usd.api.room import Room
    from openrooms_usd.importing import import_capture as read

    imported = read(kind, path_of(source), path_of(out), options or {})
    return replace(imported, room=Room.of(imported.room))
