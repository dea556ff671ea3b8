"""What was found in a scan, drawn over the scan: a plan that people judge at a glance."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final, Literal, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.lettering import lettered, stamp
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.report.canvas import (
    PAPER,
    TEXT_PIXELS,
    Canvas,
    Color,
    Pixels,
    beside,
    write_png,
)
from openrooms_usd.scan.results import FoundObject, FoundOpening, FoundRoom, Pose

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
    Caption("points of the floor", FLOOR, "dots"),
    Caption("points above it", THINGS, "dots"),
    Caption("wall", ROOM, "line"),
    Caption("wall, guessed", ROOM, "dashed"),
    Caption("door", DOOR, "thick"),
    Caption("window", WINDOW, "thick"),
    Caption("object as measured", MEASURED, "thin"),
    Caption("object as placed", PLACED, "line"),
)


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


_MAX_PIXELS: Final = 1300  # pixels of the longer side
_MAX_PIXELS_PER_M: Final = 260.0  # pixels a metre
_MARGIN_M: Final = 0.4  # paper around what is drawn, metres
# Points are drawn in blocks of about this size, so that they make surfaces, metres.
_GRAIN_M: Final = 0.018
# Returns this far below the ceiling, and above a room that shows none, are left out, metres.
_BELOW_CEILING_M: Final = 0.15
_MAX_HEIGHT_M: Final = 2.3
_MIN_HEIGHT_M: Final = -0.2
# Returns up to this high are of the floor, metres.
_FLOOR_HEIGHT_M: Final = 0.06
# Points of a block that print in full, relative to the usual number of those that have any.
_FULL_INK_COUNTS: Final = 8.0
# Of the typeface of objects' numbers, pixels.
_NUMBER_PIXELS: Final = 28
# How far from its wall words begin, pixels.
_LABEL_OFFSET_PIXELS: Final = 12.0


def write_overlay(
    path: Path,
    cloud: Cloud,
    rooms: Sequence[FoundRoom],
    objects: Sequence[FoundObject] = (),
    bounds: Mapping[str, Array] | None = None,
) -> None:
    """Write the plan of a scan and of what was found in it.

    Args:
        path: The PNG file.
        cloud: In the frame of what was found.
        rooms: Their first one's floor is the plan.
        objects: With their measured and placed poses.
        bounds: By the CAD's id, (2, 3) least and greatest coordinates in its own frame; objects
            without them are drawn as a cross.

    Raises:
        OutputError: The file cannot be written.
    """
    write_png(path, overlay(cloud, rooms, objects, bounds or {}))


def overlay(
    cloud: Cloud,
    rooms: Sequence[FoundRoom],
    objects: Sequence[FoundObject],
    bounds: Mapping[str, Array],
) -> Pixels:
    """(H, W, 3) the plan of a scan and of what was found in it; see `write_overlay`."""
    plan = plan_axes(rooms[0].normal if rooms else np.array([0.0, 0.0, 1.0]))
    origin = rooms[0].point if rooms else np.zeros(3)
    points = (cloud.points - origin) @ plan
    canvas = Canvas.over(*_extent(points, rooms, origin, plan), _MAX_PIXELS, _MAX_PIXELS_PER_M)
    _draw_points(canvas, points, rooms)
    for item in objects:
        _draw_object(canvas, item, bounds.get(item.cad), origin, plan)
    for room in rooms:
        _draw_room(canvas, room, origin, plan)
    for item in objects:
        _number(canvas, item, bounds.get(item.cad), origin, plan)
    for room in rooms:
        _name_walls(canvas, room, origin, plan)
    _draw_scale(canvas)
    words = captions(rooms, objects)
    return beside((canvas.pixels, panel(words, len(canvas.pixels))))


def plan_axes(normal: Array) -> Array:
    """(3, 3) columns: across, up the page, and out of it, for a floor's normal."""
    out = normal / np.linalg.norm(normal)
    across = np.array([1.0, 0.0, 0.0]) - out[0] * out
    if np.linalg.norm(across) < 0.1:
        across = np.array([0.0, 1.0, 0.0]) - out[1] * out
    across = across / np.linalg.norm(across)
    return np.column_stack([across, np.cross(out, across), out])


def _extent(
    points: Array, rooms: Sequence[FoundRoom], origin: Array, plan: Array
) -> tuple[Array, Array]:
    """The box of the rooms, or where there are none of most points, with paper around."""
    corners = [((room.corners - origin) @ plan)[:, :2] for room in rooms]
    if corners:
        every = np.concatenate(corners)
        more = 3 * _MARGIN_M
        return every.min(axis=0) - more, every.max(axis=0) + more
    if not len(points):
        return np.array([-1.0, -1.0]), np.array([1.0, 1.0])
    low, high = np.quantile(points[:, :2], (0.005, 0.995), axis=0)
    return low - _MARGIN_M, high + _MARGIN_M


def _draw_points(canvas: Canvas, points: Array, rooms: Sequence[FoundRoom]) -> None:
    """The floor's points, over them all others but the ceiling's: walls are many, and dark."""
    ceilings = [room.ceiling for room in rooms if room.ceiling is not None]
    top = min(ceilings) - _BELOW_CEILING_M if ceilings else _MAX_HEIGHT_M
    z = points[:, 2]
    for low, high, color in (
        (_MIN_HEIGHT_M, _FLOOR_HEIGHT_M, FLOOR),
        (_FLOOR_HEIGHT_M, top, THINGS),
    ):
        shown = points[(z > low) & (z < high), :2]
        counts = canvas.counts(shown, max(1, round(_GRAIN_M * canvas.scale)))
        if counts.any():
            canvas.pixels[:] = _printed(canvas.pixels, counts, color)


def _printed(paper: Pixels, counts: Ints, color: Color) -> Pixels:
    """Paper with ink where points are: full where they are many, darker where they are more."""
    usual = float(np.median(counts[counts > 0]))
    ink = np.minimum(np.log1p(counts / usual) / np.log1p(_FULL_INK_COUNTS), 1.0)[..., None]
    most = np.where(ink > 0.7, np.array(color) * (1.7 - ink), color)
    return np.asarray(np.round(paper + np.sqrt(ink) * (most - paper)).astype(np.uint8))


def _draw_room(canvas: Canvas, room: FoundRoom, origin: Array, plan: Array) -> None:
    corners = ((room.corners - origin) @ plan)[:, :2]
    for number, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        stroke: Stroke = "dashed" if number in room.guessed else "line"
        canvas.line(start, end, ROOM, WIDTHS[stroke], DASH if stroke == "dashed" else None)
    for hole in room.openings:
        left, right = ((hole.corners[:2] - origin) @ plan)[:, :2]
        canvas.line(left, right, OPENINGS[hole.type], WIDTHS["thick"])


def _name_walls(canvas: Canvas, room: FoundRoom, origin: Array, plan: Array) -> None:
    """Numbers outside of walls, and how sure openings are inside of theirs."""
    corners = ((room.corners - origin) @ plan)[:, :2]
    for number, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        _write_beside(canvas, f"wall {number}", start, end, ROOM)
    for hole in room.openings:
        left, right = ((hole.corners[:2] - origin) @ plan)[:, :2]
        _write_beside(canvas, _sure(hole), left, right, OPENINGS[hole.type])


def _sure(hole: FoundOpening) -> str:
    return f"{hole.type} {100 * hole.confidence:.0f}%"


def _write_beside(canvas: Canvas, text: str, start: Array, end: Array, color: Color) -> None:
    """Words at the right-hand side of a line, as one goes along it."""
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    right = np.array([along[1], -along[0]])
    height, width = lettered(text, TEXT_PIXELS).shape
    reach = 0.5 * (abs(right[0]) * width + abs(right[1]) * height)
    aside = (_LABEL_OFFSET_PIXELS + reach) / canvas.scale
    canvas.write(text, (start + end) / 2 + aside * right, color)


def _draw_object(
    canvas: Canvas, item: FoundObject, bounds: Array | None, origin: Array, plan: Array
) -> None:
    for pose, color, width in (
        (item.pose, MEASURED, WIDTHS["thin"]),
        (item.placed or item.pose, PLACED, WIDTHS["line"]),
    ):
        for start, end in _outline(pose, bounds):
            ends = (np.stack([start, end]) - origin) @ plan
            canvas.line(ends[0, :2], ends[1, :2], color, width)


def _number(
    canvas: Canvas, item: FoundObject, bounds: Array | None, origin: Array, plan: Array
) -> None:
    """An object's number in its middle; its name stands beside the plan."""
    middle = (_box(item.placed or item.pose, bounds).mean(axis=0) - origin) @ plan
    canvas.write(str(item.instance), middle[:2], INK, _NUMBER_PIXELS)


def _box(pose: Pose, bounds: Array | None) -> Array:
    """(8, 3) corners of a CAD's box as it stands, a ring at each end of what is its vertical there.

    All are at its origin where the box is not known.
    """
    ends = bounds if bounds is not None else np.zeros((2, 3))
    up = _vertical(pose)
    ring = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    sides = np.zeros((8, 3), np.int64)
    sides[:, [(up + 1) % 3, (up + 2) % 3]] = np.tile(ring, (2, 1))
    sides[4:, up] = 1
    corners = np.take_along_axis(ends, sides, axis=0)
    return turned(pose.rotation, corners * pose.scale) + pose.translation


def _vertical(pose: Pose) -> int:
    """Which axis of a CAD stands upright, nearly."""
    return int(np.abs(turned(pose.rotation, np.eye(3))[:, 2]).argmax())


def turned(rotation: Array, points: Array) -> Array:
    """(N, 3) points turned by a unit quaternion w, x, y, z."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(rotation, scalar_first=True).apply(points))


def _outline(pose: Pose, bounds: Array | None) -> Iterator[tuple[Array, Array]]:
    """The lower and upper edges of a CAD's box, and a line from its middle to its front."""
    box = _box(pose, bounds)
    for ring in (box[:4], box[4:]):
        yield from zip(ring, np.roll(ring, -1, axis=0), strict=True)
    if _vertical(pose) != 2:
        return
    # Fronts face -Y in the frame of a CAD whose vertical is Z; of others nothing is known.
    yield box[:4].mean(axis=0), box[:2].mean(axis=0)


def _draw_scale(canvas: Canvas) -> None:
    """A metre with its ends, at the lower left."""
    start = canvas.low + 0.15
    end = start + np.array([1.0, 0.0])
    half = np.array([0.0, 6.0 / canvas.scale])
    canvas.line(start, end, INK, 3.0)
    for place in (start, end):
        canvas.line(place - half, place + half, INK, 3.0)
    canvas.write("1 m", (start + end) / 2 + 3 * half, INK)
