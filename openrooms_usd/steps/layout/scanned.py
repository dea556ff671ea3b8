"""What the layout finds in a scan: the room as a capture, and a file of it all beside its layer.

The alignment reads that file, and looks for nothing again: `keep_found` and `found_in`.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

import numpy as np
from pxr import Usd
from scipy.spatial.transform import Rotation

from openrooms_usd.arrays import Array
from openrooms_usd.building.walls import walls_of
from openrooms_usd.capture import (
    Capture,
    CapturedFrame,
    CapturedOpening,
    CapturedPartition,
    Confidence,
    read_capture,
)
from openrooms_usd.description.layout import CapturedLayout, Opening, ScanLayout
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.polygons import counter_clockwise
from openrooms_usd.names import SCANNED_HEIGHT
from openrooms_usd.scan.artefact import FoundScan, digest_of, read_found, write_found
from openrooms_usd.scan.reconstruction import FoundLayout, find_rooms, without_rooms
from openrooms_usd.scan.registration.hints import Box
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.scan.rooms.flat import Flat, flat_of
from openrooms_usd.scan.rooms.layout import LayoutOptions
from openrooms_usd.steps.base import StepContext, record_of
from openrooms_usd.steps.layout.openings import hole_of

# What openings of a flat's outline are in: none of its inner walls.
_OUTER: Final = "outside"
_ALONE: Final = "no other room shares a wall with room 0, so room 0 is composed alone"
_LAYOUT: Final = "layout"
# The file of what was found, in the folder of its layer.
_FILE: Final = re.compile(r"found-([0-9a-f]{16})\.npz")
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
        chosen: The numbers of the rooms that were chosen.
        scan_from_level: (4, 4) to the frame of reports: the scan's own axes, metres.
    """

    capture: Capture
    layout: FoundLayout
    chosen: tuple[int, ...]
    scan_from_level: Array

    def found(self) -> FoundScan:
        """What is to be kept of it."""
        captured = tuple(
            (box.label, Box(box.center, box.size, turn).moved(self.layout.level.level_from_scan))
            for box in self.capture.boxes
            for turn in [Rotation.from_matrix(box.rotation).as_quat(scalar_first=True)]
        )
        return FoundScan(
            self.capture.source,
            self.layout.cloud,
            self.layout.rooms,
            self.chosen,
            self.scan_from_level,
            captured,
        )


def scanned(layout: ScanLayout, path: Path, folder: Path) -> ScannedRoom:
    """Find the room of a scan, or take the one that a person drew over it.

    Args:
        layout: The section of a description.
        path: The scan.
        folder: Where names of files in options begin.

    Raises:
        SparseScanError: It shows too little of a room, and the layout has no drawn polygon.
        InputError: It cannot be read, or has no such room.
    """
    return taken(layout, path, *find(layout, path, folder))


def find(layout: ScanLayout, path: Path, folder: Path) -> tuple[FoundLayout, Capture]:
    """All rooms of a scan; none where a person drew the room, because nothing is looked for.

    Args:
        layout: The section of a description; which room it takes changes nothing.
        path: The scan.
        folder: Where names of files in options begin.

    Raises:
        SparseScanError: It shows too little of a room.
        InputError: It cannot be read.
    """
    capture = read_capture(layout.reader, path, layout.asked, folder)
    if capture.cloud is None:
        raise InputError(
            f"the importer {layout.reader!r} does not give points",
            place=path,
            remedy="use `importer: scan`, or one that reads point clouds",
        )
    options = LayoutOptions(
        simplicity=layout.simplicity, partial=layout.partial, storey=layout.storey
    )
    try:
        found = (find_rooms if layout.polygon is None else without_rooms)(capture.cloud, options)
    except InputError as error:
        error.place = error.place or str(path)
        raise
    return found, capture


def taken(layout: ScanLayout, path: Path, found: FoundLayout, capture: Capture) -> ScannedRoom:
    """The room of a scan that a description chooses.

    Args:
        layout: The section of the description.
        path: The scan, for messages.
        found: All rooms.
        capture: What was read.

    Raises:
        InputError: There is no such room.
    """
    chosen: tuple[int, ...] = (0,)
    flat: Flat | None = None
    if layout.polygon is not None:
        found = replace(found, rooms=(drawn_room(layout),))
    else:
        chosen, flat = _chosen(found, layout.room, path)
    shown = _as_capture(capture, found, [found.rooms[number] for number in chosen])
    if flat is not None:
        shown = _flat_capture(shown, flat)
    elif layout.polygon is None and layout.room == "all" and len(found.rooms) > 1:
        shown = replace(shown, notes=(*shown.notes, _ALONE))
    scan_from_level = in_metres(capture.source_from_world) @ found.level.scan_from_level
    return ScannedRoom(shown, found, chosen, scan_from_level)


def keep_found(context: StepContext, found: FoundScan) -> None:
    """Keep what was found beside the layer, for the steps above it.

    Raises:
        OutputError: It cannot be written.
    """
    arrays = found.arrays()
    target = context.keep(f"found-{digest_of(arrays)}.npz")
    if not target.is_file():
        write_found(target, arrays)


def found_in(stage: Usd.Stage) -> FoundScan | None:
    """What the layout of a composed stage was found in; None if that was not a scan.

    Raises:
        InputError: The file of it is missing, or not what was written.
    """
    for layer in stage.GetLayerStack():
        for file in record_of(layer, _LAYOUT).get("files", ()):
            if (match := _FILE.fullmatch(str(file))) is not None:
                return read_found(Path(layer.realPath).parent / _LAYOUT / file, match[1])
    return None


def _chosen(
    found: FoundLayout, wanted: int | Literal["all"], path: Path
) -> tuple[tuple[int, ...], Flat | None]:
    """Which rooms are composed, and what they are together; None for one alone."""
    flat = flat_of(found.rooms) if wanted == "all" else None
    if flat is not None:
        return tuple(flat.members), flat
    number = 0 if wanted == "all" else wanted
    if number >= len(found.rooms):
        raise InputError(
            f"the scan has no room {number}",
            place=path,
            remedy=f"`room` is `all`, or a number of these: {_areas(found.rooms)}",
        )
    return (number,), None


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
        notes.append(f"the scan shows {told}; `room` selects one of them, or `all` that touch")
    heights = [room.ceiling for room in rooms if room.ceiling is not None]
    if not heights:
        notes.append(f"the room's height is set to {SCANNED_HEIGHT} m")
    elif max(heights) - min(heights) > _SAME_HEIGHT_M:
        notes.append(
            f"ceilings from {min(heights):.2f} to {max(heights):.2f} m became one, at the highest"
        )
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
        notes=(*capture.notes, f"the rooms {listed} are composed as one", *flat.notes),
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


def drawn_room(layout: CapturedLayout) -> FoundRoom:
    """The room that a person drew over a scan, in the level frame; what is sure has confidence 1.

    Whether its openings fit is said where they are cut.

    Args:
        layout: A section with a polygon.
    """
    assert layout.polygon is not None, "asked for where there is one"
    corners, numbers = counter_clockwise(layout.polygon)
    walls = walls_of(corners, numbers, layout.wall_thickness)
    clockwise = signed_area(np.asarray(layout.polygon)) < 0.0
    # Found walls are numbered along the corners as they run counter-clockwise.
    place = {number: index for index, number in enumerate(numbers.tolist())}
    openings = []
    for one in layout.openings:
        if one.wall is None or one.kind == "opening":
            continue
        wall = walls[one.wall]
        hole = hole_of(one, wall, clockwise=clockwise)
        ends = wall.to_plan(np.array([[hole.left, 0.0], [hole.right, 0.0]]))[[0, 1, 1, 0]]
        levels = np.array([[hole.bottom], [hole.bottom], [hole.top], [hole.top]])
        rectangle = np.hstack([ends, levels])
        openings.append(FoundOpening(_type(one), rectangle, 1.0, place[one.wall]))
    return FoundRoom(
        normal=np.array([0.0, 0.0, 1.0]),
        point=np.zeros(3),
        corners=np.column_stack([corners, np.zeros(len(corners))]),
        ceiling=layout.height,
        openings=tuple(openings),
    )


def _type(opening: Opening) -> Literal["door", "window"]:
    return "window" if opening.kind == "window" else "door"
