"""The text of a generated room: a room.yaml that people can read and change."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, Final

from openrooms_usd.atomic import filling, write_text
from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.errors import OutputError, writing
from openrooms_usd.generate.describing import (
    layout_section,
    materials_section,
    objects,
)
from openrooms_usd.generate.environments import environment
from openrooms_usd.generate.lighting import lamps, screens
from openrooms_usd.generate.moments import moment_of
from openrooms_usd.generate.rooms import USUAL_CLUTTER, Generated, generate

# Text that YAML reads as text without quotes.
_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_WORDS: Final = {"true", "false", "null"}
# What is said of the moments.
_SEEN: Final = {
    "sun": "the sun is in a window",
    "day": "a clear day",
    "overcast": "a day under clouds",
    "golden": "the sun is low",
    "dusk": "just before the day or after it",
    "night": "night",
}
# Below so many square metres views are so many degrees wide: what lenses of 26 to 31 mm show. Wider
# ones show more walls and ceiling than things.
_WIDE: Final = ((6.0, 70), (12.0, 66), (20.0, 63))
_FOV_DEG: Final = 60

ROOM: Final = "room.yaml"


def write(room: Generated) -> str:
    """The whole room.yaml."""
    return "\n".join(_lines(room)) + "\n"


def _lines(room: Generated) -> Iterator[str]:
    layout = layout_section(room)
    count = sum(len(items) for _, items in room.furnishing.groups)
    how = f"--type {room.room_type} --seed {room.seed} --clutter {room.clutter}"
    yield f"# Made by: orusd generate {how}"
    yield f"# {room.shell.area:.1f} m2, {count} objects. Lengths are metres, angles degrees."
    yield f"name: {room.room_type}_{room.seed}"
    yield f"room: {room.room_type}"
    yield f"seed: {room.seed}"
    if room.style:
        yield f"style: {room.style}"
    yield ""
    yield "layout:"
    yield "  from: polygon"
    yield "  # Wall i runs from corner i to corner i + 1."
    yield f"  polygon: {flow(layout['polygon'])}"
    yield f"  height: {flow(layout['height'])}"
    yield "  openings:"
    yield from (f"    - {flow(row)}" for row in layout["openings"])
    yield from _finish_lines(layout)
    yield ""
    yield "alignment:"
    yield "  # What is relative_to another object has its place in that object's frame: x to its"
    yield "  # right, y to its back. Move the first of a group, and the group moves."
    yield "  objects:"
    for title, rows in groupby(objects(room.furnishing), key=lambda row: row[0]):
        yield f"    # {title.capitalize()}."
        yield from (f"    - {flow(row)}" for _, row in rows)
    yield ""
    yield "materials:"
    yield from (f"  {key}: {flow(value)}" for key, value in materials_section(room).items())
    yield ""
    yield "lights:"
    yield f"  # What shines in by the openings: {_SEEN[moment_of(room.room_type, room.seed)]}."
    yield f"  environment: {flow(environment(room))}"
    yield from _lamp_lines(room)
    yield ""
    yield "cameras:"
    yield "  resolution: [640, 480]"
    yield "  views:"
    yield "    # Level views from corners and doorways, the best of many."
    yield f"    - {{from: select, count: 3, fov: {_field_of_view(room.shell.area)}}}"


def _finish_lines(layout: dict[str, Any]) -> Iterator[str]:
    """What runs along the walls, hangs below the ceiling and covers parts of the walls."""
    if "trim" in layout:
        yield "  trim:"
        yield from (f"    {key}: {flow(value)}" for key, value in layout["trim"].items())
    if "ceiling" in layout:
        yield f"  ceiling: {flow(layout['ceiling'])}"
    if "cladding" in layout:
        yield "  cladding:"
        yield from (f"    - {flow(row)}" for row in layout["cladding"])


def _field_of_view(area: float) -> int:
    """Degrees: nobody stands far enough from the furniture of a small room."""
    return next((fov for below, fov in _WIDE if area < below), _FOV_DEG)


def _lamp_lines(room: Generated) -> Iterator[str]:
    rows = lamps(room)
    if rows:
        yield "  lamps:"
    yield from (f"    {name}: {flow(row)}" for name, row in rows.items())
    shown = screens(room)
    if shown:
        yield "  screens:"
    yield from (f"    {name}: {flow(row)}" for name, row in shown.items())


def flow(value: Any) -> str:
    """Plain data in YAML's flow style."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {flow(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(flow(inner) for inner in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str) and (value in _WORDS or not _PLAIN.fullmatch(value)):
        return f'"{value}"'
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value)


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
                "there is another room already",
                place=path,
                remedy="choose another folder, or move the file away",
            )
    with filling(folder) as inside:
        write_text(inside / ROOM, text)
