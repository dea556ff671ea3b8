"""Generated rooms as files: a folder for each, with a room.yaml in it."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from openrooms_usd.atomic import filling, write_text
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
    for number in range(seed, seed + (count or 1)):
        folder = out if count is None else out / f"{room_type}_{number}"
        made = generate(room_type, number, area, style, clutter)
        _write(folder, write(made))
        yield GeneratedFile(folder / ROOM, made)


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
