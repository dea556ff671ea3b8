"""The text of a generated room: a room.yaml that people can read and change."""

import re
from collections.abc import Iterator
from itertools import groupby
from typing import Any, Final

from openrooms_usd.generation.describing import layout_section, materials_section, objects
from openrooms_usd.generation.environments import environment
from openrooms_usd.generation.lighting import lamps, screens
from openrooms_usd.generation.moments import moment_of
from openrooms_usd.generation.rooms import Generated

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
    yield "furniture:"
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
    yield f"  # Light through the openings: {_SEEN[moment_of(room.room_type, room.seed)]}."
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
    """Degrees; wider in small rooms, where cameras cannot stand far from the furniture."""
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
