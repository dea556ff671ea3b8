"""The room without furniture, as the generator sees it: walls, openings and what they keep free."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.description.layout import (
    USUAL_OPENINGS,
    Opening,
    PolygonLayout,
    named_partitions,
)
from openrooms_usd.generation.boxes import NONE, box
from openrooms_usd.geometry.floorplan import inside
from openrooms_usd.geometry.polygons import counter_clockwise

WALL_THICKNESS: Final = 0.2
"""Default thickness of outer walls, metres."""
# What a door's leaf and its handles need beside the opening, and before them, metres.
_BESIDE_DOOR_M: Final = 0.13
_BEFORE_DOOR_M: Final = 0.08
# How deep the floor before a door and a window stays free, metres.
_DOOR_APPROACH_M: Final = 0.9
_WINDOW_APPROACH_M: Final = 0.4
# What is fixed above this is high on the walls, metres.
_HIGH_M: Final = 1.5
# What reaches into the room at a window's sill, metres.
_SILL_NOSE_M: Final = 0.05


@dataclass(frozen=True, eq=False)
class Side:
    """One wall of the room, seen from inside.

    Attributes:
        start: (2,) its right end, seen from inside; metres.
        along: (2,) unit vector to its left end.
        length: Metres.
        number: The number of its edge, as the polygon was given.
    """

    start: Array
    along: Array
    length: float
    number: int

    @property
    def inward(self) -> Array:
        """(2,) unit vector into the room."""
        return np.array([-self.along[1], self.along[0]])

    @property
    def yaw(self) -> float:
        """Degrees: of what stands with its back to this wall."""
        return float(np.degrees(np.arctan2(-self.along[1], -self.along[0])))

    def point(self, at: float, away: float = 0.0) -> Array:
        """(2,) a place at a distance from the start and from the wall, metres."""
        return np.asarray(self.start + at * self.along + away * self.inward)

    def keep(
        self, at: float, width: float, depth: float, low: float, high: float
    ) -> Array:  # fmt: skip
        """(8,) a box that stands before the wall."""
        x, y = self.point(at, 0.5 * depth)
        return box(float(x), float(y), width, depth, low, high, self.yaw)


@dataclass(frozen=True)
class Gap:
    """A hole in a wall.

    Attributes:
        kind: What it is.
        side: The index of its wall in `Shell.sides`.
        at: From the wall's start to its middle, metres.
        width: Metres.
        sill: Height of its lower edge, metres.
        top: Height of its upper edge, metres.
        swing: Where a door's leaf goes.
        hinge: The hinge side of a door, seen from inside.
    """

    kind: Literal["window", "door", "opening"]
    side: int
    at: float
    width: float
    sill: float
    top: float
    swing: Literal["in", "out"] = "in"
    hinge: Literal["left", "right"] = "left"


@dataclass(frozen=True, eq=False)
class Shell:
    """A room's polygon, its height and its openings.

    Attributes:
        corners: (N, 2) counter-clockwise, metres.
        height: Floor to ceiling, metres.
        gaps: The openings.
        numbers: For each edge, its number as the polygon was given.
        clockwise: Whether the polygon was given clockwise.
        standing: (P, 8) the walls that stand free, as boxes.
        free: (K, 8) what must stay free before their openings.
        fixed: (F, 8) what is fixed along the walls.
        beams: (B, 8) what hangs below the ceiling.
        casing: Width of the boards around openings, metres.
        thickness: Of the outer walls, metres.
    """

    corners: Array
    height: float
    gaps: tuple[Gap, ...] = ()
    numbers: tuple[int, ...] = ()
    clockwise: bool = False
    standing: Array = field(default_factory=lambda: NONE)
    free: Array = field(default_factory=lambda: NONE)
    fixed: Array = field(default_factory=lambda: NONE)
    beams: Array = field(default_factory=lambda: NONE)
    casing: float = 0.0
    thickness: float = WALL_THICKNESS

    def with_fixed(self, fixed: Array, beams: Array, casing: float) -> "Shell":
        """The same with what is fixed in it."""
        return replace(self, fixed=fixed, beams=beams, casing=casing)

    @cached_property
    def attached(self) -> Array:
        """(F + B, 8) all that is fixed."""
        return np.concatenate([self.fixed, self.beams])

    @cached_property
    def clear_height(self) -> float:
        """Up to where nothing is fixed high on the walls or below the ceiling, metres."""
        high = self.attached[self.attached[:, 6] > _HIGH_M, 6]
        return float(min(high.min(initial=self.height), self.height))

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        """The walls, counter-clockwise."""
        ends = np.roll(self.corners, -1, axis=0) - self.corners
        lengths = np.linalg.norm(ends, axis=1)
        numbers = self.numbers or range(len(ends))
        return tuple(
            Side(start, end / length, float(length), number)
            for start, end, length, number in zip(self.corners, ends, lengths, numbers, strict=True)
        )

    @property
    def area(self) -> float:
        """Square metres."""
        x, y = self.corners.T
        return 0.5 * float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)))

    @cached_property
    def walls(self) -> Array:
        """(N, 8) the walls' inner faces as boxes without thickness, and the walls inside."""
        flat = [side.keep(0.5 * side.length, side.length, 0.0, -1.0, 99.0) for side in self.sides]
        return np.concatenate([np.array(flat), self.standing])

    @cached_property
    def kept(self) -> Array:
        """(K, 8) what must stay free before openings, for furniture and what hangs on walls."""
        rows = [row for gap in self.gaps for row in self._before(gap)]
        return np.concatenate([np.array(rows) if rows else NONE, self.free])

    def _before(self, gap: Gap) -> Iterator[Array]:
        side = self.sides[gap.side]
        if gap.kind == "window":
            low = gap.sill - 0.02
            yield side.keep(gap.at, gap.width, _WINDOW_APPROACH_M, low + 0.05, gap.top)
            beside = max(0.06, self.casing + 0.03)
            yield side.keep(gap.at, gap.width + 2 * beside, _SILL_NOSE_M, low, gap.top + beside)
        else:
            swept = gap.width + _BEFORE_DOOR_M if gap.kind == "door" and gap.swing == "in" else 0.0
            depth = max(_DOOR_APPROACH_M, swept)
            yield side.keep(gap.at, gap.width + 2 * _BESIDE_DOOR_M, depth, 0.0, gap.top + 0.1)

    @cached_property
    def kept_on_tops(self) -> Array:
        """(K, 8) what of `kept` is free of what stands on furniture: it may stand at a window."""
        rows = [row for gap in self.gaps for row in list(self._before(gap))[gap.kind == "window" :]]
        return np.concatenate([np.array(rows) if rows else NONE, self.free])

    @property
    def doors(self) -> tuple[Gap, ...]:
        """What people come in by."""
        return tuple(gap for gap in self.gaps if gap.kind != "window" and gap.sill < 0.1)

    def contains(self, points: Array) -> Mask:
        """(...) which of (..., 2) points lie inside."""
        found = inside(self.corners, points.reshape(-1, 2)).reshape(points.shape[:-1])
        return np.asarray(found, dtype=np.bool_)


def shell_of(layout: PolygonLayout) -> Shell:
    """A described room."""
    corners, numbers = counter_clockwise(layout.polygon)
    shell = Shell(corners, layout.height, (), tuple(numbers.tolist()), _turned(numbers.tolist()))
    gaps = tuple(_gap(o, shell) for o in layout.openings if o.wall is not None)
    standing, free = _standing(layout)
    return Shell(
        corners, layout.height, gaps, shell.numbers, shell.clockwise, standing, free,
        thickness=layout.wall_thickness,
    )  # fmt: skip


def _standing(layout: PolygonLayout) -> tuple[Array, Array]:
    """(P, 8) the partitions as boxes, and (K, 8) what must stay free at their openings."""
    walls, free = [], []
    for name, one in named_partitions(layout.partitions):
        start, end = np.array(one.line)
        length = float(np.linalg.norm(end - start))
        yaw = float(np.degrees(np.arctan2(end[1] - start[1], end[0] - start[0])))
        along, done = (end - start) / length, 0.0
        ways = [o for o in layout.openings if o.partition == name and o.kind != "window"]
        for at, opening in sorted(((_place(o, length), o) for o in ways), key=lambda row: row[0]):
            width = opening.width or USUAL_OPENINGS[opening.kind][0]
            swept = width + _BEFORE_DOOR_M if opening.kind == "door" else 0.0
            deep = one.thickness + 2.0 * max(_DOOR_APPROACH_M, swept)
            x, y = start + at * along
            free.append(box(x, y, width + 2 * _BESIDE_DOOR_M, deep, 0.0, 99.0, yaw))
            walls.append(_between(start, along, done, at - 0.5 * width, one.thickness))
            done = at + 0.5 * width
        walls.append(_between(start, along, done, length, one.thickness))
    return (np.array(walls) if walls else NONE), (np.array(free) if free else NONE)


def _place(opening: Opening, length: float) -> float:
    return 0.5 * length if opening.at is None else opening.at


def _between(start: Array, along: Array, low: float, high: float, thickness: float) -> Array:
    """(8,) the piece of a wall that stands free between two distances from its start."""
    x, y = start + 0.5 * (low + high) * along
    yaw = float(np.degrees(np.arctan2(along[1], along[0])))
    return box(float(x), float(y), max(high - low, 0.0), thickness, -1.0, 99.0, yaw)


def _turned(numbers: Sequence[int]) -> bool:
    return list(numbers) != sorted(numbers)


def _gap(opening: Opening, shell: Shell) -> Gap:
    assert opening.wall is not None
    index = shell.numbers.index(opening.wall)
    length = shell.sides[index].length
    given = (opening.width, opening.height, opening.sill)
    width, height, sill = (
        usual if value is None else value
        for value, usual in zip(given, USUAL_OPENINGS[opening.kind], strict=True)
    )
    at = 0.5 * length if opening.at is None else opening.at
    at = length - at if shell.clockwise else at
    swing, hinge = opening.swing, opening.hinge
    return Gap(opening.kind, index, at, width, sill, sill + height, swing, hinge)
