"""What stages find in a scan: the room as a capture, the furniture as CADs at their poses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from openrooms_usd.capture import (
    Capture,
    CapturedFrame,
    CapturedOpening,
    CapturedPartition,
    Confidence,
    read_capture,
)
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.errors import InputError
from openrooms_usd.names import SCANNED_HEIGHT
from openrooms_usd.scan.reconstruction import FoundLayout, find_rooms, without_rooms
from openrooms_usd.scan.registration.hints import Box, Hint
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.scan.rooms.flat import Flat, flat_of
from openrooms_usd.scan.rooms.layout import LayoutOptions
from openrooms_usd.stages.base import StageContext, input_file
from openrooms_usd.stages.captures import capture_path
from openrooms_usd.stages.drawn import drawn_room
from openrooms_usd.stages.instances import hint_of

Array = NDArray[np.float64]

# What openings of a flat's outline are in: none of its inner walls.
_OUTER: Final = "outside"
_ALONE: Final = "no other room stands wall to wall with room 0, which is taken alone"
# Ceilings whose heights differ by less are one, metres.
_SAME_HEIGHT_M: Final = 0.1
# Least confidence of each word.
_WORDS: Final[tuple[tuple[float, Confidence], ...]] = ((0.75, "high"), (0.4, "medium"))


@dataclass(frozen=True, eq=False)
class ScannedRoom:
    """The room of a scan, in the level frame, which is the world of the composed stage.

    Attributes:
        capture: As of any other captured room.
        layout: All that was found.
        rooms: Those that were chosen.
        scan_from_level: (4, 4) to the frame of reports: the scan's own axes, metres.
        boxes: Around those things that were told apart but have no name, by their numbers.
    """

    capture: Capture
    layout: FoundLayout
    rooms: tuple[FoundRoom, ...]
    scan_from_level: Array
    boxes: Mapping[int, Box] = field(default_factory=dict)


def scanned_room(context: StageContext, layout: ScanLayout) -> ScannedRoom:
    """Find the room of a scan.

    Raises:
        InputError: The scan cannot be read, or shows too little of a room.
    """
    return scanned(layout, capture_path(context, layout), context.source)


def scanned(layout: ScanLayout, path: Path, folder: Path) -> ScannedRoom:
    """Find the room of a scan, or take the one that a person drew over it.

    Args:
        layout: The section of a description.
        path: The scan.
        folder: Where names of files in options begin.

    Raises:
        SparseScanError: It shows too little of a room, and nobody drew one.
        InputError: It cannot be read, or has no such room.
    """
    found, capture = _read(layout, path, folder)
    if layout.polygon is not None:
        found = replace(found, rooms=(drawn_room(layout),))
        rooms, flat = found.rooms, None
    else:
        rooms, flat = _chosen(found, layout.room, path)
    shown = _as_capture(capture, found, rooms)
    if flat is not None:
        shown = _flat_capture(shown, flat)
    elif layout.room == "all" and len(found.rooms) > 1:
        shown = replace(shown, notes=(*shown.notes, _ALONE))
    scan_from_level = in_metres(capture.source_from_world) @ found.level.scan_from_level
    return ScannedRoom(shown, found, rooms, scan_from_level)


def found_rooms(layout: ScanLayout, folder: Path) -> tuple[Array, tuple[FoundRoom, ...]]:
    """The points of a scan, and the rooms that are taken of it; a stage finds them done next.

    Args:
        layout: The section of a description.
        folder: Where its files' names begin.

    Returns:
        (N, 3) in the level frame, metres, and the rooms in the same.

    Raises:
        SparseScanError: It shows too little of a room.
        InputError: It cannot be read, or has no such room.
    """
    path = input_file(folder, layout.file, folders=True)
    found, _ = _read(layout, path, folder)
    if layout.polygon is not None:
        return found.cloud.points, (drawn_room(layout),)
    return found.cloud.points, _chosen(found, layout.room, path)[0]


def _read(layout: ScanLayout, path: Path, source: Path) -> tuple[FoundLayout, Capture]:
    asked = tuple(sorted(layout.asked.items()))
    stamp = path.stat().st_mtime_ns, path.stat().st_size
    options = LayoutOptions(
        simplicity=layout.simplicity, partial=layout.partial, storey=layout.storey
    )
    drawn = layout.polygon is not None
    return _found(layout.reader, options, path, asked, source, stamp, drawn=drawn)


def _chosen(
    found: FoundLayout, wanted: int | Literal["all"], path: Path
) -> tuple[tuple[FoundRoom, ...], Flat | None]:
    """The rooms that are composed, and what they are together; None for one alone."""
    flat = flat_of(found.rooms) if wanted == "all" else None
    if flat is not None:
        return tuple(found.rooms[number] for number in flat.members), flat
    number = 0 if wanted == "all" else wanted
    if number >= len(found.rooms):
        raise InputError(
            f"the scan has no room {number}",
            place=path,
            remedy=f"`room` is `all`, or a number of these: {_areas(found.rooms)}",
        )
    return (found.rooms[number],), None


@lru_cache(maxsize=1)
def _found(
    reader: str,
    options: LayoutOptions,
    path: Path,
    asked: tuple[tuple[str, str], ...],
    source: Path,
    stamp: tuple[int, int],
    *,
    drawn: bool,
) -> tuple[FoundLayout, Capture]:
    """All rooms of a scan: two stages ask for the same, one after the other.

    None where a person drew the room: then nothing is looked for.
    """
    capture = read_capture(reader, path, dict(asked), source)
    if capture.cloud is None:
        raise InputError(
            f"the importer {reader!r} gives no points",
            place=path,
            remedy="use `importer: scan`, or one that reads point clouds",
        )
    try:
        found = (without_rooms if drawn else find_rooms)(capture.cloud, options)
    except InputError as error:
        error.place = error.place or str(path)
        raise
    return found, capture


def captured_hints(scanned: ScannedRoom) -> list[Hint] | None:
    """The boxes of a capture whose points have no instances, in the level frame.

    Returns:
        None where the points say themselves what is an object, or the capture has no boxes.
    """
    instances, boxes = scanned.layout.cloud.instance, scanned.capture.boxes
    if not boxes or (instances is not None and instances.any()):
        return None
    hints = []
    for number, box in enumerate(boxes, 1):
        turn = Rotation.from_matrix(box.rotation).as_quat(scalar_first=True)
        around = Box(box.center, box.size, turn).moved(scanned.layout.level.level_from_scan)
        bottom = float(around.center[2] - 0.5 * box.size[2])
        hints.append(hint_of(number, (box.label,), bottom, box=around))
    return hints


def in_metres(source_from_world: Array) -> Array:
    """(4, 4) the same rigid motion, to the source's axes in metres."""
    unit = np.cbrt(abs(np.linalg.det(source_from_world[:3, :3])))
    return np.asarray(np.diag([1.0, 1.0, 1.0, unit]) @ source_from_world / unit)


def _areas(rooms: Sequence[FoundRoom]) -> str:
    """What rooms there are, by number and area."""
    from shapely import Polygon

    return ", ".join(
        f"{number} ({Polygon(room.corners[:, :2]).area:.1f} m2)"
        for number, room in enumerate(rooms)
    )


def _as_capture(capture: Capture, found: FoundLayout, rooms: Sequence[FoundRoom]) -> Capture:
    """The first of some rooms as a capture, as high as the highest of them."""
    notes = [*capture.notes, *found.notes]
    if len(found.rooms) > len(rooms):
        told = f"{len(found.rooms)} rooms, by number and area: {_areas(found.rooms)}"
        notes.append(f"the scan shows {told}; `room` takes one of them, or `all` that touch")
    heights = [room.ceiling for room in rooms if room.ceiling is not None]
    if not heights:
        notes.append(f"{SCANNED_HEIGHT} m is taken for the room's height")
    elif max(heights) - min(heights) > _SAME_HEIGHT_M:
        notes.append(f"ceilings from {min(heights):.2f} to {max(heights):.2f} m became one, as "
                     "high as the highest")  # fmt: skip
    return replace(
        capture,
        source_from_world=capture.source_from_world @ found.level.scan_from_level,
        floor=rooms[0].corners[:, :2],
        height=max(heights, default=SCANNED_HEIGHT),
        openings=tuple(_opening(n, o) for n, o in enumerate(rooms[0].openings)),
        frames=tuple(_frame(frame, found.level.level_from_scan) for frame in capture.frames),
        cloud=found.cloud,
        notes=tuple(notes),
    )


def _flat_capture(capture: Capture, flat: Flat) -> Capture:
    """The capture with the floor of several rooms, and the walls between them."""
    listed = ", ".join(map(str, flat.members))
    return replace(
        capture,
        floor=flat.corners,
        openings=tuple(
            replace(
                _opening(number, one.opening),
                wall=_OUTER if one.between is None else _between(one.between),
            )
            for number, one in enumerate(flat.openings)
        ),
        partitions=tuple(
            CapturedPartition(_between(number), wall.ends, wall.thickness)
            for number, wall in enumerate(flat.walls)
        ),
        notes=(*capture.notes, f"the rooms {listed} are taken as one", *flat.notes),
    )


def _between(number: int) -> str:
    return f"between{number}"


def _frame(frame: CapturedFrame, level_from_world: Array) -> CapturedFrame:
    return replace(frame, world_from_camera=level_from_world @ frame.world_from_camera)


def _opening(number: int, found: FoundOpening) -> CapturedOpening:
    along, up = found.corners[1] - found.corners[0], found.corners[3] - found.corners[0]
    return CapturedOpening(
        id=str(number),
        kind=found.type,
        center=found.corners.mean(axis=0),
        direction=along / np.linalg.norm(along),
        width=float(np.linalg.norm(along)),
        height=float(np.linalg.norm(up)),
        confidence=next((word for least, word in _WORDS if found.confidence >= least), "low"),
    )
