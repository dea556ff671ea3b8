"""What stands beside a plan: what its colours mean, its rooms, openings and objects."""

from collections.abc import Iterator, Sequence
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.lettering import lettered, stamp
from openrooms_usd.scan.report.canvas import PAPER, TEXT_PIXELS, Canvas, Color, Pixels, beside
from openrooms_usd.scan.results import FoundObject, FoundRoom

Array = NDArray[np.float64]
Stroke = Literal["thin", "line", "dashed", "thick", "dots"]

INK: Final[Color] = (20, 20, 20)
FLOOR: Final[Color] = (228, 212, 184)
THINGS: Final[Color] = (90, 90, 90)
ROOM: Final[Color] = (200, 30, 30)
DOOR: Final[Color] = (20, 150, 60)
WINDOW: Final[Color] = (30, 110, 230)
MEASURED: Final[Color] = (240, 150, 30)
PLACED: Final[Color] = (150, 40, 170)
OPENINGS: Final = {"door": DOOR, "window": WINDOW}
# Widths of strokes, pixels, and the dashes of those that are dashed: ink and gap.
WIDTHS: Final[dict[Stroke, float]] = {"thin": 1.5, "line": 2.5, "dashed": 2.5, "thick": 8.0}
DASH: Final = (11.0, 9.0)

_ROW_PIXELS: Final = 26  # pixels
_SWATCH_PIXELS: Final = 34
_GAP_PIXELS: Final = 12
# Motions below this are not worth a word, metres.
_MIN_MOTION_M: Final = 0.005


class Caption(NamedTuple):
    """A line of words, and a stroke before it where there is one."""

    text: str
    color: Color = INK
    stroke: Stroke | None = None


LEGEND: Final = (
    Caption("points of the floor", FLOOR, "dots"), Caption("points above it", THINGS, "dots"),
    Caption("wall", ROOM, "line"), Caption("wall, guessed", ROOM, "dashed"),
    Caption("door", DOOR, "thick"), Caption("window", WINDOW, "thick"),
    Caption("object as measured", MEASURED, "thin"), Caption("object as placed", PLACED, "line"),
)  # fmt: skip


def captions(rooms: Sequence[FoundRoom], objects: Sequence[FoundObject]) -> tuple[Caption, ...]:
    """The legend, a paragraph for each room, and a line for each object."""
    return (*LEGEND, *_about_rooms(rooms), *_about_objects(objects))


def _about_rooms(rooms: Sequence[FoundRoom]) -> Iterator[Caption]:
    if not rooms:
        yield Caption("")
        yield Caption("no room was found", ROOM)
    for number, room in enumerate(rooms):
        high = "no ceiling seen" if room.ceiling is None else f"{room.ceiling:.2f} m high"
        yield Caption("")
        yield Caption(f"room {number}: {_area(room):.1f} m2, {high}", ROOM)
        if room.guessed:
            yield Caption(f"  guessed: wall {', '.join(map(str, room.guessed))}", ROOM)
        for hole in room.openings:
            wide, tall = (float(np.linalg.norm(hole.corners[i] - hole.corners[0])) for i in (1, 3))
            words = f"  {hole.type} in wall {hole.wall}: {wide:.2f} x {tall:.2f} m, "
            yield Caption(f"{words}{100 * hole.confidence:.0f}%", OPENINGS[hole.type])


def _about_objects(objects: Sequence[FoundObject]) -> Iterator[Caption]:
    if objects:
        yield Caption("")
        yield Caption(f"{len(objects)} objects", PLACED)
    for item in objects:
        moved = np.linalg.norm((item.placed or item.pose).translation - item.pose.translation)
        how = f", moved {100 * moved:.0f} cm" if moved > _MIN_MOTION_M else ""
        yield Caption(f"  {item.instance} {item.category}{how}")


def _area(room: FoundRoom) -> float:
    """Square metres, in the plane of the floor."""
    ahead = np.roll(room.corners, -1, axis=0)
    return abs(0.5 * float(np.cross(room.corners, ahead).sum(axis=0) @ room.normal))


def panel(lines: Sequence[Caption], height: int) -> Pixels:
    """Lines of words below each other, in as many columns as a picture's height needs."""
    rows = max((height - 2 * _GAP_PIXELS) // _ROW_PIXELS, len(LEGEND))
    columns = [lines[first : first + rows] for first in range(0, len(lines), rows)]
    return beside([_column(column) for column in columns])


def _column(lines: Sequence[Caption]) -> Pixels:
    words = [lettered(line.text, TEXT_PIXELS) for line in lines]
    width = max(ink.shape[1] for ink in words) + _SWATCH_PIXELS + 3 * _GAP_PIXELS
    shape = (len(lines) * _ROW_PIXELS + 2 * _GAP_PIXELS, width, 3)
    canvas = Canvas(np.full(shape, PAPER, np.uint8), np.zeros(2), 1.0)
    for number, (line, ink) in enumerate(zip(lines, words, strict=True)):
        middle = _GAP_PIXELS + number * _ROW_PIXELS + _ROW_PIXELS // 2
        if line.stroke:
            _draw_swatch(canvas, line, middle)
        left = 2 * _GAP_PIXELS + _SWATCH_PIXELS if line.stroke else _GAP_PIXELS
        color = INK if line.stroke == "dots" else line.color
        stamp(canvas.pixels, ink, left, middle - ink.shape[0] // 2, color)
    return canvas.pixels


def _draw_swatch(canvas: Canvas, line: Caption, middle: int) -> None:
    if line.stroke in (None, "dots"):
        canvas.pixels[middle - 7 : middle + 7, _GAP_PIXELS : _GAP_PIXELS + _SWATCH_PIXELS] = (
            line.color
        )
        return
    y = len(canvas.pixels) - middle
    ends = np.array([[_GAP_PIXELS, y], [_GAP_PIXELS + _SWATCH_PIXELS, y]], dtype=np.float64)
    dash = DASH if line.stroke == "dashed" else None
    canvas.line(ends[0], ends[1], line.color, WIDTHS[line.stroke], dash)
