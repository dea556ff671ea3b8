"""Apple RoomPlan: a CapturedRoom, exported as JSON, becomes a Capture.

The world frame is Z up with the floor at 0. Its X axis runs along the longest wall, the way that
needs the least rotation, and the room lies at positive x and y: numbers that people can write
down, however far from the origin the source is.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.capture import Capture, CapturedBox, CapturedOpening
from orusd_scans.capturedroom import CapturedRoom, Record, read_captured_room
from orusd_scans.floorplan import chained, heading, tidied

Array = NDArray[np.float64]

# Y up to Z up: (x, y, z) -> (x, -z, y).
_Z_UP: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
# Columns: our right, back and up in RoomPlan's object axes, which are right, up and front.
_BOX_AXES: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
# Openings nearer than this part of their width are one, seen twice.
_SAME: Final = 0.25
_CONFIDENCE: Final = {"high": 2, "medium": 1, "low": 0, None: -1}


@dataclass(frozen=True, eq=False)
class _Frame:
    """The rigid motion from the source's frame to the world: world = rotation (source - origin)."""

    rotation: Array
    origin: Array

    def points(self, source: Array) -> Array:
        """Points (..., 3); the origin is taken off first, in double precision."""
        return np.asarray((source - self.origin) @ self.rotation.T)

    def source_from_world(self) -> Array:
        """(4, 4) the way back, for column vectors."""
        M = np.eye(4)
        M[:3, :3], M[:3, 3] = self.rotation.T, self.origin
        return M


class RoomPlanImporter:
    """Reads the JSON export of Apple RoomPlan (iOS 16 and later)."""

    def read(self, source: Path) -> Capture:
        """Read a CapturedRoom.

        Args:
            source: The JSON file.

        Raises:
            InputError: It is missing, is no such file, or holds nonsense; names the place.
        """
        room, notes = read_captured_room(source), list[str]()
        outline = _outline(room, notes)
        frame = _frame(room, outline)
        # Nanometres are noise of the rotation.
        corners = None if outline is None else np.round(frame.points(outline)[:, :2], 9) + 0.0
        floor = None if corners is None else tidied(corners, notes)
        notes += _approximations(room)
        openings = [
            *(_opening(record, "door", frame) for record in room.doors),
            *(_opening(record, "window", frame) for record in room.windows),
            *(_opening(record, "opening", frame) for record in room.openings),
        ]
        return Capture(
            source=source.name,
            source_from_world=frame.source_from_world(),
            floor=floor,
            height=_height(room, frame),
            openings=tuple(_distinct(openings, notes)),
            boxes=tuple(_box(record, frame) for record in room.objects),
            notes=tuple(notes),
        )


def _placed(record: Record, local: Array) -> Array:
    """Local points (N, 3) of a record in the source's frame."""
    return local @ record.source_from_local[:3, :3].T + record.center


def _rectangle(record: Record) -> Array:
    x, y = 0.5 * record.size[0], 0.5 * record.size[1]
    return np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])


def _outline(room: CapturedRoom, notes: list[str]) -> Array | None:
    """(N, 3) the corners of the floor in the source's frame."""
    floors = [_placed(f, f.corners if len(f.corners) else _rectangle(f)) for f in room.floors]
    if floors:
        if len(floors) > 1:
            notes.append(f"the capture has {len(floors)} floors: the largest was taken")
        return max(floors, key=_plan_area)
    if not room.walls:
        return None
    # Relative to one point, so that sums and differences far from the origin stay exact.
    base = room.walls[0].center
    ends = np.array([_placed(wall, _rectangle(wall)[:2]) - base for wall in room.walls])
    corners = chained((ends @ _Z_UP.T)[:, :, :2], notes)
    if corners is None:
        return None
    level = np.full(len(corners), float(np.median(ends[:, :, 1])))
    return np.column_stack([corners[:, 0], level, -corners[:, 1]]) + base


def _plan_area(corners: Array) -> float:
    x, z = (corners - corners[0])[:, [0, 2]].T
    return abs(float(x @ np.roll(z, -1) - z @ np.roll(x, -1)))


def _frame(room: CapturedRoom, outline: Array | None) -> _Frame:
    if outline is None:
        centers = [record.center for record in (*room.walls, *room.objects)]
        return _Frame(_Z_UP, np.mean(centers, axis=0) if centers else np.zeros(3))
    plan = (outline - outline[0]) @ _Z_UP.T
    angle = heading(plan[:, :2])
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ _Z_UP
    turned = (outline - outline[0]) @ rotation.T
    corner = np.array([*turned[:, :2].min(axis=0), np.median(turned[:, 2])])
    return _Frame(rotation, outline[0] + corner @ rotation)


def _height(room: CapturedRoom, frame: _Frame) -> float | None:
    """The ceiling's height: the median of the walls' tops, weighted by their lengths."""
    walls = [wall for wall in room.walls if wall.size[0] > 0.0 and wall.size[1] > 0.0]
    if not walls:
        return None
    tops = np.array([frame.points(_placed(w, _rectangle(w)))[:, 2].max() for w in walls])
    order = np.argsort(tops)
    weight = np.cumsum(np.array([wall.size[0] for wall in walls])[order])
    return float(tops[order][np.searchsorted(weight, 0.5 * weight[-1])])


def _opening(
    record: Record, kind: Literal["window", "door", "opening"], frame: _Frame
) -> CapturedOpening:
    direction = frame.rotation @ record.source_from_local[:3, 0]
    level = np.array([direction[0], direction[1], 0.0])
    is_open = record.details.get("isOpen")
    return CapturedOpening(
        id=record.id,
        kind=kind,
        center=frame.points(record.center),
        direction=level / max(float(np.linalg.norm(level)), 1e-12),
        width=float(record.size[0]),
        height=float(record.size[1]),
        is_open=None if is_open is None else is_open == "True",
        confidence=record.confidence,
    )


def _distinct(openings: list[CapturedOpening], notes: list[str]) -> list[CapturedOpening]:
    """The openings without those that another one repeats; the surer one stays."""
    kept: list[CapturedOpening] = []
    for opening in openings:
        twin = next((other for other in kept if _is_same(opening, other)), None)
        if twin is None:
            kept.append(opening)
            continue
        notes.append(f"{twin.kind} {twin.id} and {opening.kind} {opening.id} are one, seen twice")
        if _CONFIDENCE[opening.confidence] > _CONFIDENCE[twin.confidence]:
            kept[kept.index(twin)] = opening
    return kept


def _is_same(a: CapturedOpening, b: CapturedOpening) -> bool:
    near = float(np.linalg.norm(a.center - b.center)) < _SAME * min(a.width, b.width)
    return near and abs(float(a.direction @ b.direction)) > 0.95


def _box(record: Record, frame: _Frame) -> CapturedBox:
    # The source's rotations are rounded to single precision: take the nearest exact one.
    left, _, right = np.linalg.svd(frame.rotation @ record.source_from_local[:3, :3] @ _BOX_AXES)
    width, height, depth = record.size
    return CapturedBox(
        id=record.id,
        label=record.category,
        center=frame.points(record.center),
        rotation=left @ right,
        size=np.array([width, depth, height]),
        confidence=record.confidence,
        attributes=record.details,
    )


def _approximations(room: CapturedRoom) -> list[str]:
    curved = sum(record.curved for record in room.walls)
    sloped = sum(len(record.corners) not in (0, 4) for record in room.walls)
    notes = []
    if curved:
        notes.append(f"{curved} curved walls are built as straight ones")
    if sloped:
        notes.append(f"{sloped} walls that are no rectangles are built up to the full height")
    return notes
