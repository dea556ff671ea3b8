"""A floor drawn beside a capture: its corners, its height and what is cut into its walls.

The file is JSON, either a plain list of corners or an object::

    {"floor": [[0, 0], [5, 0], [5, 4], [0, 4]], "level": 0.05, "height": 2.5,
     "openings": [{"id": "w1", "kind": "window", "center": [2, 0, 1.5], "width": 1.2, "height": 1}]}

or a CSV table of corners with the columns x and y. Corners are horizontal: x and y in a source
with Z up, x and z in one with Y up. All numbers are in the frame and the unit of the capture.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, get_args

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedOpening
from openrooms_usd.geometry.polygons import counter_clockwise, defect
from openrooms_usd.geometry.rotations import about_z
from orusd_scans.floorplan import heading
from orusd_scans.records import (
    Node,
    choice,
    flag,
    identifiers,
    number,
    positive,
    read_json,
    read_table,
)
from orusd_scans.worldframe import MAX_COORDINATE_M, Z_UP, WorldFrame

Up = Literal["Y", "Z"]
Opened = Literal["window", "door", "opening"]

# Largest sides of rooms and openings, in the source's unit: rooms in millimetres pass.
MAX_SIDE: Final = 1e6
_MOST_CORNERS: Final = 10_000
_REMEDY: Final = "list the inner corners once, in order around the room"


@dataclass(frozen=True, eq=False)
class DrawnPlan:
    """A floor in the upright frame of a source: its own axes, turned to Z up, in its own unit.

    Attributes:
        corners: (N, 2) counter-clockwise from above.
        level: Height of the floor; None when it is not stated.
        height: Floor to ceiling; None when it is not stated.
        openings: The records of what is cut into the walls.
    """

    corners: Array
    level: float | None = None
    height: float | None = None
    openings: tuple[Node, ...] = ()


def read_plan(path: Path, up: Up) -> DrawnPlan:
    """Read a floor from a file of its own.

    Raises:
        InputError: It is missing, or no simple polygon; names the place.
    """
    if path.suffix.lower() == ".csv":
        columns = ("x", "y" if up == "Z" else "z")
        rows = [[row.need(column).value for column in columns] for row in read_table(path, columns)]
        return DrawnPlan(_corners(Node(rows, path), up))
    root = read_json(path)
    if isinstance(root.value, list):
        return DrawnPlan(_corners(root, up))
    found = plan_of(root, up)
    if found is None:
        raise root.error("'floor' is missing", "give the corners of the floor under this key")
    return found


def plan_of(root: Node, up: Up) -> DrawnPlan | None:
    """The floor that an object holds under ``floor``; None where it has none.

    Raises:
        InputError: It is not a simple polygon, or a number is absurd.
    """
    floor = root.get("floor")
    if floor is None:
        return None
    return DrawnPlan(
        _corners(floor, up), level_of(root), height_of(root), tuple(root.items("openings"))
    )


def level_of(root: Node) -> float | None:
    """The floor's height along the up axis that an object states."""
    level = root.get("level")
    return number(level, MAX_COORDINATE_M) if level else None


def height_of(root: Node) -> float | None:
    """The height of the room that an object states."""
    height = root.get("height")
    return positive(height, MAX_SIDE) if height else None


def _corners(node: Node, up: Up) -> Array:
    items = Node({"": node.value}, node.file, node.path).items("")
    if not 3 <= len(items) <= _MOST_CORNERS:
        raise node.error(f"3 to {_MOST_CORNERS:,} corners expected, found {len(items)}", _REMEDY)
    pairs = [
        Node(item.value, node.file, f"{node.path}[{i}]").numbers(2, MAX_COORDINATE_M)
        for i, item in enumerate(items)
    ]
    corners = np.array(pairs) * [1.0, 1.0 if up == "Z" else -1.0]
    if reason := defect(corners):
        raise node.error(f"the polygon {reason}", _REMEDY)
    return counter_clockwise(corners)[0]


def frame_along(plan: DrawnPlan, level: float, up: Up) -> WorldFrame:
    """The world frame of a floor: its longest wall along an axis, all of it at positive x and y.

    Args:
        plan: The floor, in metres.
        level: Its height.
        up: The source's up axis.
    """
    angle = heading(plan.corners)
    turn = about_z(angle)
    # Relative to one corner, so that rotating far from the origin stays exact.
    turned = (plan.corners - plan.corners[0]) @ turn[:2, :2].T
    corner = np.array([*turned.min(axis=0), 0.0]) @ turn
    origin = np.array([*plan.corners[0], level]) + corner
    return WorldFrame(turn @ Z_UP[up], origin @ Z_UP[up])


def floor_in(frame: WorldFrame, plan: DrawnPlan, up: Up) -> Array:
    """(N, 2) the floor's corners in the world, metres."""
    lifted = np.column_stack([plan.corners, np.zeros(len(plan.corners))]) @ Z_UP[up]
    # Nanometres are noise of the rotation.
    return np.asarray(np.round(frame.points(lifted)[:, :2], 9) + 0.0)


def openings_in(
    frame: WorldFrame, openings: Sequence[Node], floor: Array
) -> tuple[CapturedOpening, ...]:
    """The openings of a floor in the world, each along the wall that is nearest to it.

    Args:
        frame: The way to the world.
        openings: Their records.
        floor: (N, 2) its corners in the world.

    Raises:
        InputError: A field is missing or absurd, or an identifier repeats.
    """
    ids = identifiers(openings, "opening")
    return tuple(_opening(node, id_, frame, floor) for node, id_ in zip(openings, ids, strict=True))


def _opening(node: Node, identifier: str, frame: WorldFrame, floor: Array) -> CapturedOpening:
    kind: Opened = choice(node.need("kind"), get_args(Opened))  # type: ignore[assignment]
    center = frame.points(node.need("center").numbers(3, MAX_COORDINATE_M))
    is_open = node.get("open")
    return CapturedOpening(
        id=identifier,
        kind=kind,
        center=center,
        direction=_along(center, floor),
        width=frame.unit * positive(node.need("width"), MAX_SIDE),
        height=frame.unit * positive(node.need("height"), MAX_SIDE),
        is_open=flag(is_open) if is_open else None,
    )


def _along(point: Array, floor: Array) -> Array:
    """(3,) the direction of the wall that is nearest to a point."""
    walls = np.roll(floor, -1, axis=0) - floor
    offset = point[:2] - floor
    part = np.clip(np.sum(offset * walls, axis=1) / np.sum(walls * walls, axis=1), 0.0, 1.0)
    distance = np.linalg.norm(offset - part[:, None] * walls, axis=1)
    wall = walls[int(np.argmin(distance))]
    return np.array([*(wall / np.linalg.norm(wall)), 0.0])
