"""What is true of a capture, as it is traced: JSON beside the data."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array


@dataclass(frozen=True, eq=False)
class Frame:
    """The plan in which a truth is drawn.

    Attributes:
        origin: (3,) a point of the floor in the capture's axes, metres.
        axes: (3, 3) rows: across, along and up, unit vectors in the capture's axes.
    """

    origin: Array
    axes: Array

    def plan(self, points: ArrayLike) -> Array:
        """(N, 3) points of the capture as places in the plan and heights above the floor."""
        return np.asarray((np.asarray(points, float).reshape(-1, 3) - self.origin) @ self.axes.T)

    def turned(self, turn: Array) -> "Frame":
        """The same plan in axes that are turned by a (3, 3) rotation."""
        return Frame(turn @ self.origin, self.axes @ turn.T)


@dataclass(frozen=True)
class Hole:
    """A door, a window or a passage in a wall, as found or as true.

    Attributes:
        type: ``door``, ``window`` or ``opening``.
        ends: Its two ends in the plan, metres.
        bottom: Metres above the floor.
        top: Metres above the floor.
        certain: What is not counts neither for nor against, whether it is found or not.
        passage: A doorway without a leaf: ``door`` and ``opening`` are both right.
        divided: It has several panes: a part of it counts neither for nor against.
        confidence: That of the one who found it.
    """

    type: str
    ends: tuple[tuple[float, float], tuple[float, float]]
    bottom: float
    top: float
    certain: bool = True
    passage: bool = False
    divided: bool = False
    confidence: float | None = None


@dataclass(frozen=True)
class TrueRoom:
    """A room: its outline, other outlines that are as right, and its openings if traced."""

    name: str
    outlines: tuple[Array, ...]
    openings: tuple[Hole, ...] | None
    ceiling: float | None = None


@dataclass(frozen=True)
class TrueThing:
    """An object: number, label, middle in the plan, (long, short, height), inside the room."""

    instance: str
    label: str
    middle: tuple[float, float]
    size: tuple[float, float, float]
    inside: bool


@dataclass(frozen=True)
class Truth:
    """What is true of a capture.

    Attributes:
        kind: ``scan`` or ``roomplan``.
        up_axis: Of the file, for people.
        unit: Metres to a unit of the file.
        frame: Of the plan; None for RoomPlan.
        rooms: The first is the one that is meant, unless `many`.
        things: The objects that carry a number.
        many: Any of the rooms is right as the first.
        loose: The outline is hidden by a third: not scored.
        axis_only: The scan shows too little of a room: its axis alone is scored.
        raw: All that the file says; RoomPlan's exports are read from it.
    """

    kind: str
    up_axis: str
    unit: float
    frame: Frame | None
    rooms: tuple[TrueRoom, ...]
    things: tuple[TrueThing, ...]
    many: bool
    loose: bool
    axis_only: bool
    raw: Mapping[str, Any]


def truth_of(path: Path) -> Truth:
    """Read the truth of a capture."""
    raw = json.loads(path.read_text(encoding="utf-8"))
    scan = raw.get("kind", "scan") == "scan"
    return Truth(
        kind=raw.get("kind", "scan"),
        up_axis=raw["up_axis"],
        unit=raw["unit_m"],
        frame=_frame(raw["frame"]) if scan else None,
        rooms=tuple(_room(entry) for entry in raw["rooms"]) if scan else (),
        things=tuple(_thing(entry) for entry in raw["objects"]) if scan else (),
        many=raw.get("multi_room", False),
        loose=raw.get("loose", False),
        axis_only=raw.get("compose_only", False),
        raw=raw,
    )


def _frame(raw: Mapping[str, Sequence[float]]) -> Frame:
    axes = np.array([raw[name] for name in ("x", "y", "up")], float)
    return Frame(np.array(raw["origin"], float), axes / np.linalg.norm(axes, axis=1, keepdims=True))


def _room(raw: Mapping[str, Any]) -> TrueRoom:
    outlines = (raw["polygon"], *raw.get("alternatives", ()))
    holes = raw["openings"]
    return TrueRoom(
        raw["name"],
        tuple(np.array(outline, float) for outline in outlines),
        None if holes is None else tuple(_hole(hole) for hole in holes),
        raw.get("ceiling_height"),
    )


def _hole(raw: Mapping[str, Any]) -> Hole:
    (a, b), (c, d) = raw["segment"]
    flags = {name: bool(raw.get(name)) for name in ("certain", "passage", "divided")}
    return Hole(raw["type"], ((a, b), (c, d)), raw["bottom"], raw["top"], **flags)


def _thing(raw: Mapping[str, Any]) -> TrueThing:
    x, y, _ = raw["center"]
    long, short, height = raw["size"]
    return TrueThing(
        str(raw["instance"]), raw["label"], (x, y), (long, short, height), raw["inside"]
    )
