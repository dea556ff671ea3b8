"""What was captured under a plan: points that people draw over, and what was found in them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.building.walls import Wall
from openrooms_usd.capture import Capture, read_capture
from openrooms_usd.description.generate import GeneratedLayout
from openrooms_usd.description.layout import (
    USUAL_OPENINGS,
    CapturedLayout,
    Opening,
    Partition,
    PolygonLayout,
    ScanLayout,
)
from openrooms_usd.description.room import Room
from openrooms_usd.errors import InputError, SparseScanError
from openrooms_usd.names import ROOM_HEIGHT, SCANNED_HEIGHT
from openrooms_usd.steps.base import input_file
from openrooms_usd.steps.layout.openings import Cut
from openrooms_usd.steps.layout.scanned import ScannedRoom, find, scanned, taken
from openrooms_usd.steps.layout.step import Plan, plan_of
from openrooms_usd.view.plan.drawing import Drawing, Point

# What cuts and descriptions of openings call alike.
_SAME: Final = ("kind", "name", "open", "hinge", "swing", "style", "beyond")


@dataclass(frozen=True, eq=False)
class Underlay:
    """What a room was captured as.

    Attributes:
        capture: What was read; None for a room that comes from no capture.
        points: (N, 3) in the frame of the room, metres; without rows where there are none.
        colors: (N, 3) uint8, sRGB; None where the points have none.
        found: Plans of what was found, by the number of the room or ``all``.
        notes: What was dropped or guessed.
    """

    capture: Capture | None = None
    points: Array = field(default_factory=lambda: np.empty((0, 3)))
    colors: Bytes | None = None
    found: Mapping[str, Drawing] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def underlay_of(room: Room, folder: Path) -> Underlay:
    """Read what a room was captured as, and find the rooms of a scan.

    Args:
        room: The description.
        folder: Where names of files in it begin.

    Raises:
        InputError: It cannot be read, or is a room whose walls are drawn by a seed.
    """
    layout = room.layout
    if isinstance(layout, GeneratedLayout):
        raise walls_of_a_seed()
    if not isinstance(layout, CapturedLayout):
        return Underlay()
    path = input_file(folder, layout.file, folders=True)
    plain = layout.model_copy(
        update={"polygon": None, "height": None, "openings": (), "partitions": ()}
    )
    own = plain.model_copy(update={"openings": layout.openings, "partitions": layout.partitions})
    # What is described beside the captured openings belongs to the plan that is found.
    shown = own if layout.polygon is None else plain
    if isinstance(layout, ScanLayout):
        assert isinstance(shown, ScanLayout), "a copy"
        return _of_scan(shown, path, folder)
    capture = read_capture(layout.reader, path, layout.asked, folder)
    notes = list(capture.notes)
    found = {} if capture.floor is None else {"0": _found_drawing(shown, capture, folder, notes)}
    points = np.empty((0, 3)) if capture.cloud is None else capture.cloud.points
    colors = None if capture.cloud is None else capture.cloud.colors
    return Underlay(capture, points, colors, found, tuple(notes))


def walls_of_a_seed() -> InputError:
    """What to raise for a room without corners to move."""
    return InputError(
        "the walls of this room come from its seed and cannot be moved",
        place="layout",
        remedy="`orusd generate` writes a room whose walls have corners",
    )


def _of_scan(layout: ScanLayout, path: Path, folder: Path) -> Underlay:
    notes: list[str] = []
    found: dict[str, Drawing] = {}
    try:
        rooms, capture = find(layout, path, folder)
        first = taken(layout, path, rooms, capture)
        count = len(rooms.rooms)
        for wanted in (*range(count), *(["all"] if count > 1 else [])):
            one = taken(layout.model_copy(update={"room": wanted}), path, rooms, capture)
            if wanted != "all" or len(one.chosen) > 1:
                found[str(wanted)] = _found_drawing(layout, one.capture, folder, notes)
    except SparseScanError as error:
        notes.append(f"{error.message}: draw the room")
        first = _unseen(layout, path, folder)
    cloud = first.layout.cloud
    capture = replace(first.capture, openings=(), partitions=())
    return Underlay(capture, cloud.points, cloud.colors, found, (*first.capture.notes, *notes))


def _unseen(layout: ScanLayout, path: Path, folder: Path) -> ScannedRoom:
    """A scan in which nothing is looked for."""
    anything = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))
    update = {"polygon": anything, "openings": (), "partitions": ()}
    return scanned(layout.model_copy(update=update), path, folder)


def _found_drawing(
    layout: CapturedLayout, capture: Capture, folder: Path, notes: list[str]
) -> Drawing:
    return drawing_of_built(plan_of(layout, capture, folder, notes))


def first_drawing(layout: PolygonLayout | CapturedLayout, under: Underlay) -> Drawing:
    """The plan that a description begins with: what it says, else what was found, else a box."""
    if layout.polygon is not None:
        return drawing_of_section(layout, under)
    wanted = str(layout.room) if isinstance(layout, ScanLayout) else "0"
    drawing = under.found.get(wanted) or under.found.get("0")
    if drawing is None:
        drawing = boxed(under)
    height = layout.height or drawing.height
    return replace(drawing, height=height, thickness=layout.wall_thickness)


def boxed(under: Underlay) -> Drawing:
    """A plan to begin with where no room was found: a box around most of the points."""
    points = under.points[:, :2] if len(under.points) else np.array([[0.0, 0.0], [5.0, 4.0]])
    (x0, y0), (x1, y1) = np.percentile(points, (2, 98), axis=0).tolist()
    return Drawing(((x0, y0), (x1, y0), (x1, y1), (x0, y1)), SCANNED_HEIGHT)


def drawing_of_section(layout: PolygonLayout | CapturedLayout, under: Underlay) -> Drawing:
    """The plan of a section with a polygon; what it leaves out is as compose takes it."""
    assert layout.polygon is not None, "asked for where there is one"
    captured = under.capture.height if under.capture is not None else None
    plan = Drawing(
        layout.polygon,
        layout.height or captured or ROOM_HEIGHT,
        (),
        layout.partitions,
        layout.wall_thickness,
    )
    return replace(plan, openings=tuple(_whole(one, plan) for one in layout.openings))


def _whole(opening: Opening, plan: Drawing) -> Opening:
    """An opening with all its measures."""
    start, end = plan.line(opening)
    width, height, sill = USUAL_OPENINGS[opening.kind]
    usual = {
        "at": 0.5 * float(np.linalg.norm(end - start)),
        "width": width,
        "height": height,
        "sill": sill,
    }
    given = {name: getattr(opening, name) for name in usual}
    return opening.model_copy(
        update={name: usual[name] if value is None else value for name, value in given.items()}
    )


def drawing_of_built(built: Plan) -> Drawing:
    """The plan of a room as compose would build it from its capture."""
    partitions = tuple(
        Partition.model_construct(
            name=wall.partition,
            line=_middle_line(wall),
            thickness=wall.thickness,
            height=wall.height,
        )
        for wall in built.walls
        if wall.partition
    )
    corners = tuple((float(x), float(y)) for x, y in built.corners)
    return Drawing(
        corners,
        built.height,
        tuple(_opening(cut) for cut in built.cuts),
        partitions,
        built.thickness,
    )


def _middle_line(wall: Wall) -> tuple[Point, Point]:
    ends = np.array([[0.0, 0.5 * wall.thickness], [wall.length, 0.5 * wall.thickness]])
    (a, b), (c, d) = wall.to_plan(ends).tolist()
    return (a, b), (c, d)


def _opening(cut: Cut) -> Opening:
    wall, hole = cut.wall, cut.hole
    middle = 0.5 * (hole.left + hole.right)
    told: dict[str, Any] = {name: getattr(cut, name) for name in _SAME}
    return Opening.model_construct(
        **told,
        wall=None if wall.partition else wall.number,
        partition=wall.partition,
        # Outlines that run counter-clockwise start on the right, seen from inside.
        at=middle if wall.partition else wall.length - middle,
        width=hole.right - hole.left,
        height=hole.top - hole.bottom,
        sill=hole.bottom,
    )
