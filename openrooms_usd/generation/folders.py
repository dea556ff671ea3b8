"""Generated rooms as files: a folder for each, with a room.yaml in it."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from openrooms_usd.atomic import write_text
from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.errors import OutputError, writing
from openrooms_usd.generation.rooms import USUAL_CLUTTER, Generated, generate
from openrooms_usd.generation.writing import write

ROOM: Final = "room.yaml"


@dataclass(frozen=True, eq=False)
class GeneratedFile:
    """A generated room and where it was written.

    Attributes:
        file: Its ``room.yaml``.
        made: What was generated.
    """

    file: Path
    made: Generated

    @property
    def objects(self) -> int:
        """How many objects stand in it."""
        return sum(len(items) for _, items in self.made.furnishing.groups)

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {
            "room": str(self.file),
            "type": self.made.room_type,
            "seed": self.made.seed,
            "style": self.made.style,
            "area": round(self.made.shell.area, 2),
            "objects": self.objects,
        }


def generate_rooms(
    room_type: str,
    seed: int,
    out: Path,
    *,
    count: int | None = None,
    area: float | None = None,
    style: InteriorStyle | None = None,
    clutter: int = USUAL_CLUTTER,
) -> Iterator[GeneratedFile]:
    """Write the descriptions of some rooms.

    Args:
        room_type: One of the 27.
        seed: Of the first room.
        out: The folder; made when it is missing.
        count: How many rooms, each in a folder of its own; one in ``out`` itself by default.
        clutter: How much lies about: 0 nothing, 1 tidy, 2 lived in, 3 messy.
        area: Floor area, square metres.
        style: Of furniture, materials and colours; drawn for each room by default.

    Yields:
        Each room, once it is written.

    Raises:
        OutputError: A folder cannot be written, or holds another room.
    """
    files = {
        number: (out if count is None else out / f"{room_type}_{number}") / ROOM
        for number in range(seed, seed + (count or 1))
    }

    def made(number: int) -> Generated:
        return generate(room_type, number, area, style, clutter)

    # Nothing is written where a later room could not be.
    known = {number: made(number) for number, file in files.items() if os.path.lexists(file)}
    for number, room in known.items():
        _check_same(files[number], write(room))
    for number, file in files.items():
        room = known.get(number) or made(number)
        write_text(file, write(room))
        yield GeneratedFile(file, room)


def _check_same(path: Path, text: str) -> None:
    with writing(path):
        is_same = path.is_file() and path.read_bytes() == text.encode()
    if not is_same:
        raise OutputError(
            "the folder already has another room",
            place=path,
            remedy="choose another folder, or move the file away",
        )
