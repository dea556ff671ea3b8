"""What was found in a scan, drawn over the scan: a plan that people judge at a glance."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.canvas import PAPER, Canvas, Color, Pixels, stacked, write_png
from openrooms_usd.scan.cloud import Cloud
from openrooms_usd.scan.lettering import lettered
from openrooms_usd.scan.results import FoundObject, FoundOpening, FoundRoom, Pose

Array = NDArray[np.float64]

_MOST: Final = 1600  # pixels of the longer side
_FINEST: Final = 160.0  # pixels a metre
_EDGE: Final = 0.4  # paper around what is drawn, metres
# Returns this far below the ceiling, and above a room that shows none, are left out, metres.
_UNDER: Final = 0.15
_HIGHEST: Final = 2.3
_BELOW: Final = -0.2
# Points of a pixel that print as black, relative to the usual number of those that have any.
_BLACK: Final = 12.0
_DASH: Final = (9.0, 7.0)

_INK: Final[Color] = (20, 20, 20)
_ROOM: Final[Color] = (200, 30, 30)
_DOOR: Final[Color] = (20, 150, 60)
_WINDOW: Final[Color] = (30, 110, 230)
_MEASURED: Final[Color] = (240, 150, 30)
_PLACED: Final[Color] = (150, 40, 170)
_OPENINGS: Final = {"door": _DOOR, "window": _WINDOW}
_LEGEND: Final = (
    ("wall", _ROOM), ("- - guessed wall", _ROOM), ("door", _DOOR), ("window", _WINDOW),
    ("object measured", _MEASURED), ("object placed", _PLACED),
)  # fmt: skip


def write_overlay(
    path: Path, cloud: Cloud, rooms: Sequence[FoundRoom], objects: Sequence[FoundObject] = (),
    bounds: Mapping[str, Array] | None = None,
) -> None:  # fmt: skip
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
    cloud: Cloud, rooms: Sequence[FoundRoom], objects: Sequence[FoundObject],
    bounds: Mapping[str, Array],
) -> Pixels:  # fmt: skip
    """(H, W, 3) the plan of a scan and of what was found in it; see `write_overlay`."""
    plan = plan_axes(rooms[0].normal if rooms else np.array([0.0, 0.0, 1.0]))
    origin = rooms[0].point if rooms else np.zeros(3)
    points = (cloud.points - origin) @ plan
    canvas = Canvas.over(*_extent(points, rooms, origin, plan), _MOST, _FINEST)
    _draw_points(canvas, points, rooms)
    for item in objects:
        _draw_object(canvas, item, bounds.get(item.cad), origin, plan)
    for room in rooms:
        _draw_room(canvas, room, origin, plan)
    _draw_scale(canvas)
    return stacked((canvas.pixels, _legend()))


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
        more = 3 * _EDGE
        return every.min(axis=0) - more, every.max(axis=0) + more
    if not len(points):
        return np.array([-1.0, -1.0]), np.array([1.0, 1.0])
    low, high = np.quantile(points[:, :2], (0.005, 0.995), axis=0)
    return low - _EDGE, high + _EDGE


def _draw_points(canvas: Canvas, points: Array, rooms: Sequence[FoundRoom]) -> None:
    """Points without the ceiling's in grey: walls are many above each other, and dark."""
    ceilings = [room.ceiling for room in rooms if room.ceiling is not None]
    top = min(ceilings) - _UNDER if ceilings else _HIGHEST
    shown = points[(points[:, 2] > _BELOW) & (points[:, 2] < top), :2]
    counts = canvas.counts(shown)
    if not counts.any():
        return
    usual = float(np.median(counts[counts > 0]))
    ink = np.log1p(counts / usual) / np.log1p(_BLACK)
    canvas.pixels[:] = np.round(PAPER[0] * (1.0 - 0.85 * np.minimum(ink, 1.0)))[..., None]


def _draw_room(canvas: Canvas, room: FoundRoom, origin: Array, plan: Array) -> None:
    corners = ((room.corners - origin) @ plan)[:, :2]
    for number, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        guessed = number in room.guessed
        canvas.line(start, end, _ROOM, 2.5, _DASH if guessed else None)
        _number_wall(canvas, start, end, number)
    for hole in room.openings:
        _draw_opening(canvas, hole, origin, plan)


def _number_wall(canvas: Canvas, start: Array, end: Array, number: int) -> None:
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    outward = np.array([along[1], -along[0]])
    canvas.write(str(number), (start + end) / 2 + 0.25 * outward, _ROOM)


def _draw_opening(canvas: Canvas, hole: FoundOpening, origin: Array, plan: Array) -> None:
    left, right = ((hole.corners[:2] - origin) @ plan)[:, :2]
    color = _OPENINGS[hole.type]
    canvas.line(left, right, color, 7.0)
    along = (right - left) / max(float(np.linalg.norm(right - left)), 1e-9)
    inward = np.array([along[1], -along[0]])
    canvas.write(f"{100 * hole.confidence:.0f}%", (left + right) / 2 + 0.15 * inward, color)


def _draw_object(
    canvas: Canvas, item: FoundObject, bounds: Array | None, origin: Array, plan: Array
) -> None:
    for pose, color, width in (
        (item.pose, _MEASURED, 1.5), (item.placed or item.pose, _PLACED, 2.5),
    ):  # fmt: skip
        for start, end in _outline(pose, bounds):
            ends = (np.stack([start, end]) - origin) @ plan
            canvas.line(ends[0, :2], ends[1, :2], color, width)
    middle = (_box(item.placed or item.pose, bounds).mean(axis=0) - origin) @ plan
    canvas.write(f"{item.instance} {item.category}", middle[:2], _INK)


def _box(pose: Pose, bounds: Array | None) -> Array:
    """(8, 3) corners of a CAD's box as it stands; all at its origin where the box is not known."""
    low, high = bounds if bounds is not None else np.zeros((2, 3))
    corners = np.array([[x, y, z] for z in (low[2], high[2])
                        for x, y in ((low[0], low[1]), (high[0], low[1]),
                                     (high[0], high[1]), (low[0], high[1]))])  # fmt: skip
    return turned(pose.rotation, corners * pose.scale) + pose.translation


def turned(rotation: Array, points: Array) -> Array:
    """(N, 3) points turned by a unit quaternion w, x, y, z."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(rotation, scalar_first=True).apply(points))


def _outline(pose: Pose, bounds: Array | None) -> Iterator[tuple[Array, Array]]:
    """The lower and upper edges of a CAD's box, and a line from its middle to its front."""
    box = _box(pose, bounds)
    for ring in (box[:4], box[4:]):
        yield from zip(ring, np.roll(ring, -1, axis=0), strict=True)
    # Fronts face -Y in the CAD's frame.
    yield box[:4].mean(axis=0), box[:2].mean(axis=0)


def _draw_scale(canvas: Canvas) -> None:
    """A metre, at the lower left."""
    start = canvas.low + 0.15
    canvas.line(start, start + np.array([1.0, 0.0]), _INK, 3.0)
    canvas.write("1 m", start + np.array([0.5, 0.12]), _INK)


def _legend() -> Pixels:
    words = [(lettered(text, 2), color) for text, color in _LEGEND]
    gap, height = 24, 26
    width = sum(ink.shape[1] for ink, _ in words) + gap * (len(words) + 1)
    canvas = Canvas(np.full((height, width, 3), PAPER, np.uint8), np.zeros(2), 1.0)
    column = gap
    for ink, color in words:
        canvas.stamp(ink, column, (height - ink.shape[0]) // 2, color)
        column += ink.shape[1] + gap
    return canvas.pixels
