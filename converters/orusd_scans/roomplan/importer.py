"""Apple RoomPlan: its exports become Captures.

The world frame is Z up with the floor at 0. Its X axis runs along the longest wall, the way that
needs the least rotation, and the room lies at positive x and y: numbers that people can write
down, however far from the origin the source is.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedBox, CapturedOpening
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import about_z
from orusd_scans.floorplan import from_lower_left, heading, tidied
from orusd_scans.roomplan.inner import InnerWalls, inner_walls
from orusd_scans.roomplan.records import CapturedRoom, Record, read_captured_rooms
from orusd_scans.roomplan.spaces import Z_UP, chosen_space, placed, rectangle
from orusd_scans.worldframe import WorldFrame

# Columns: our right, back and up in RoomPlan's object axes, which are right, up and front.
_BOX_AXES: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
# Openings nearer to each other than this part of their width are duplicates.
_SAME_OPENING_SHARE: Final = 0.25
_CONFIDENCE: Final = {"high": 2, "medium": 1, "low": 0, None: -1}


class RoomPlanImporter:
    """Reads the exports of Apple RoomPlan (iOS 16 and later): JSON, or parametric USDZ."""

    options: Mapping[str, str] = {
        "room": "which room: its label, such as livingRoom, its number, or all of a storey as one; "
        "by default the largest"
    }

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read a CapturedRoom or a CapturedStructure.

        Args:
            source: The JSON or USDZ file.
            options: ``room``: which room of several is meant.

        Raises:
            InputError: It is missing, is no such file, holds nonsense, or has no such room; names
                the place.
        """
        notes: list[str] = []
        try:
            space = chosen_space(_rooms(source, notes), options.get("room"), notes)
        except InputError as error:
            error.place = error.place or str(source)
            raise
        room, frame = space.records, _frame(space.records, space.outline)
        # Nanometres are noise of the rotation.
        outline = space.outline
        corners = None if outline is None else np.round(frame.points(outline)[:, :2], 9) + 0.0
        floor = None if corners is None else tidied(corners, notes)
        floor = None if floor is None else from_lower_left(floor)
        notes += _approximations(room)
        # Walls outside belong to other rooms, where there are any.
        told = notes if space.is_whole else []
        inner = (
            InnerWalls() if floor is None else inner_walls(room.walls, floor, frame.points, told)
        )
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
            openings=tuple(
                replace(opening, wall=inner.wall_of(opening.wall))
                for opening in _distinct(openings, notes)
            ),
            partitions=inner.partitions,
            boxes=tuple(_box(record, frame) for record in room.objects),
            notes=tuple(notes),
        )


def _rooms(source: Path, notes: list[str]) -> list[CapturedRoom]:
    if source.suffix.lower() != ".usdz":
        return read_captured_rooms(source, notes)
    # USD takes a third of a second to import, and most captures are JSON.
    from orusd_scans.roomplan.usdz import read_usdz

    return [read_usdz(source, notes)]


def _frame(room: CapturedRoom, outline: Array | None) -> WorldFrame:
    if outline is None:
        centers = [record.center for record in (*room.walls, *room.objects)]
        return WorldFrame(Z_UP, np.mean(centers, axis=0) if centers else np.zeros(3))
    plan = (outline - outline[0]) @ Z_UP.T
    angle = heading(plan[:, :2])
    rotation = about_z(angle) @ Z_UP
    turned = (outline - outline[0]) @ rotation.T
    corner = np.array([*turned[:, :2].min(axis=0), np.median(turned[:, 2])])
    return WorldFrame(rotation, outline[0] + corner @ rotation)


def _height(room: CapturedRoom, frame: WorldFrame) -> float | None:
    """The ceiling's height: the median of the walls' tops, weighted by their lengths."""
    walls = [wall for wall in room.walls if wall.size[0] > 0.0 and wall.size[1] > 0.0]
    if not walls:
        return None
    tops = np.array([frame.points(placed(w, rectangle(w)))[:, 2].max() for w in walls])
    order = np.argsort(tops)
    weight = np.cumsum(np.array([wall.size[0] for wall in walls])[order])
    return float(tops[order][np.searchsorted(weight, 0.5 * weight[-1])])


def _opening(
    record: Record, kind: Literal["window", "door", "opening"], frame: WorldFrame
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
        wall=record.parent,
    )


def _distinct(openings: list[CapturedOpening], notes: list[str]) -> list[CapturedOpening]:
    """The openings without duplicates; the one of higher confidence stays."""
    kept: list[CapturedOpening] = []
    cells: defaultdict[tuple[int, ...], list[int]] = defaultdict(list)
    side = _SAME_OPENING_SHARE * max((opening.width for opening in openings), default=1.0) + 1e-9
    for opening in openings:
        cell = np.floor(opening.center / side).astype(int)
        near = (index for place in _around(cell) for index in cells[place])
        twin = next((index for index in near if _is_same(opening, kept[index])), None)
        if twin is None:
            cells[tuple(cell.tolist())].append(len(kept))
            kept.append(opening)
            continue
        other = kept[twin]
        notes.append(f"{other.kind} {other.id} and {opening.kind} {opening.id} are one, seen twice")
        if _CONFIDENCE[opening.confidence] > _CONFIDENCE[other.confidence]:
            kept[twin] = opening
            cells[tuple(cell.tolist())].append(twin)
    return kept


def _around(cell: NDArray[np.int_]) -> Iterator[tuple[int, ...]]:
    """A cell of a grid and those that touch it."""
    yield from product(*((i - 1, i, i + 1) for i in cell.tolist()))


def _is_same(a: CapturedOpening, b: CapturedOpening) -> bool:
    near = float(np.linalg.norm(a.center - b.center)) < _SAME_OPENING_SHARE * min(a.width, b.width)
    return near and abs(float(a.direction @ b.direction)) > 0.95


def _box(record: Record, frame: WorldFrame) -> CapturedBox:
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
    sloped = sum(len(record.corners) not in (0, 4) for record in room.walls)
    walls = "wall that is no rectangle is" if sloped == 1 else "walls that are no rectangles are"
    return [f"{sloped} {walls} built up to the full height"] if sloped else []
