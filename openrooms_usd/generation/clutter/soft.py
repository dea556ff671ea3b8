"""Seats and beds: cushions that lean on what is behind them, things that lie on what gives way."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import offered_surfaces
from openrooms_usd.furniture.placements import Place
from openrooms_usd.generation.boxes import Pose
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.laying import PosedObject
from openrooms_usd.generation.clutter.resting import Relief, rest_on
from openrooms_usd.generation.items import Item, placed, wrapped
from openrooms_usd.generation.shapes import BuiltForm
from openrooms_usd.geometry.rotations import about_z

# A seat is level to this, metres; nothing leans on what is lower than this above it.
_SEAT_M: Final = 0.05
# Steps in which a leaning thing is pushed back, metres, and how far it may rise on the way.
_STEP_M: Final = 0.01
_RISE_M: Final = 0.012
# Of the lowest points of a thing none is farther than this above what it lies on, metres.
_MAX_GAP_M: Final = 0.013
_LOWEST_M: Final = 0.005
# What leans touches what is behind to this, metres, by its part above this share of its height.
_TOUCH_M: Final = 0.0005
_UPPER_SHARE: Final = 0.4
# Degrees: one step of the search for the angle, its steps, and the most that something leans.
_TURN_DEG: Final = 1.0
_TURNS: Final = 6
_MAX_LEAN_DEG: Final = 32.0
# It swings round where one of its sides is farther from what is behind, metres.
_MAX_SIDE_GAP_M: Final = 0.012
# Down becomes backwards.
_BACKWARDS: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
# Which part of a bed or a seat is meant: least and greatest x and y, as shares of its size.
_PARTS: Final[dict[Place, tuple[float, float, float, float]]] = {
    "bed_head": (-0.42, 0.42, 0.0, 0.45),
    "bed_foot": (-0.36, 0.36, -0.46, -0.16),
}
SOFT: Final[tuple[Place, ...]] = (*_PARTS, "sofa_seat", "armchair_seat", "chair_seat")
_SEAT: Final = (-0.46, 0.46, -0.42, 0.4)


@dataclass(frozen=True, eq=False)
class Seat:
    """What people sit or lie on.

    Attributes:
        place: ``sofa_seat``, ``bed_foot`` and so on.
        carrier: What it belongs to.
        group: The index of the group of the carrier.
        relief: The carrier's upper side.
        shape: The carrier's form.
    """

    place: Place
    carrier: Item
    group: int
    relief: Relief
    shape: BuiltForm

    @property
    def pose(self) -> Pose:
        """Of the carrier in the room."""
        return self.carrier.x, self.carrier.y, self.carrier.yaw

    @property
    def reach(self) -> tuple[float, float, float, float]:
        """Least and greatest x, least and greatest y in the carrier's frame, metres."""
        width, depth, _ = self.carrier.size
        x0, x1, y0, y1 = _PARTS.get(self.place, _SEAT)
        return x0 * width, x1 * width, y0 * depth, y1 * depth

    @property
    def area(self) -> float:
        """Square metres."""
        x0, x1, y0, y1 = self.reach
        return (x1 - x0) * (y1 - y0)

    @property
    def height(self) -> float:
        """Of the seat above the carrier's base: what most of its front has; metres."""
        x0, x1, y0, y1 = self.reach
        front = np.linspace(y0 + 0.1 * (y1 - y0), y0 + 0.4 * (y1 - y0), 9)
        x, y = np.meshgrid(np.linspace(0.7 * x0, 0.7 * x1, 15), front)
        return float(np.median(self.relief.at(x, y)))


def seats(groups: Sequence[tuple[str, Sequence[Item]]], surfaces: LevelFinder) -> Iterator[Seat]:
    """All seats and beds of a furnished room.

    Args:
        groups: Titles and items, in the room's frame.
        surfaces: Knows their forms.
    """
    for number, (_, items) in enumerate(groups):
        for item in items:
            offered = offered_surfaces(item.category)
            for place in (place for place in offered if place in SOFT):
                yield Seat(place, item, number, surfaces.relief(item), surfaces.shape(item))


def lean(
    seat: Seat, thing: PosedObject, key: str, rng: np.random.Generator
) -> tuple[Item, Pose] | None:  # fmt: skip
    """A thing pushed back on a seat until it meets what is behind, and leans on that.

    Returns:
        The item, and the place of its origin in the carrier's frame; None where it does not fit.
    """
    x0, x1, y0, y1 = seat.reach
    half = 0.5 * thing.size[0]
    if x1 - x0 < 2 * half:
        return None
    # Cushions end up at the arms more often than in the middle.
    side = float(rng.beta(0.55, 0.55))
    x = x0 + half + side * (x1 - x0 - 2 * half)
    yaw = float(rng.uniform(-9.0, 9.0)) + 14.0 * (0.5 - side)
    points = thing.skin @ about_z(np.radians(yaw)).T
    steps = np.arange(y0 + 0.25 * (y1 - y0), y1, _STEP_M)
    z = seat.relief.rest(points, np.full(len(steps), x), steps)
    level = seat.height - float(thing.low[2])
    flat = np.abs(z - level) < _SEAT_M
    flat &= np.concatenate([[True], np.diff(z) < _RISE_M])
    if not flat[0]:
        return None
    count = len(flat) if flat.all() else int(np.argmin(flat))
    if count == len(flat):  # There is nothing to lean on.
        return None
    # A little before that place it may stand better, and still leans.
    tried = (
        _leant(seat, thing, key, (x, float(steps[at]), yaw))
        for at in range(count - 1, max(count - 4, -1), -1)
    )
    return next((laid for laid in tried if laid is not None), None)


def _leant(seat: Seat, thing: PosedObject, key: str, place: Pose) -> tuple[Item, Pose] | None:
    """The thing at a place, turned back until it touches what is behind."""
    before: tuple[float, float] | None = None
    for _ in range(_TURNS):
        gap = _gap_behind(seat, thing, place)
        if gap is None:
            return None
        if abs(gap) <= _TOUCH_M:
            break
        angle = thing.tilt[0]
        turn = -_TURN_DEG if gap > 0.0 else _TURN_DEG
        if before is not None and gap != before[1]:
            turn = -gap * (angle - before[0]) / (gap - before[1])
        before = angle, gap
        thing = thing.turned((float(np.clip(angle + turn, -_MAX_LEAN_DEG, 0.0)), thing.tilt[1]))
        if thing.tilt[0] == angle:
            return None
    else:
        return None
    sides = [_gap_behind(seat, thing, place, side) for side in (-1.0, 1.0)]
    if any(gap is None or gap > _MAX_SIDE_GAP_M for gap in sides):
        return None
    points = thing.skin @ about_z(np.radians(place[2])).T
    return _laid(seat, thing, key, points, place)


def _gap_behind(seat: Seat, thing: PosedObject, place: Pose, side: float = 0.0) -> float | None:
    """How far the upper part of a thing, or a side of it, is in front of what is behind, metres."""
    corners = thing.above(place)
    z = rest_on(seat.shape.corners, corners)
    if not np.isfinite(z):
        return None
    corners = corners + np.array([0.0, 0.0, z])
    low, high = corners[..., 2].min(), corners[..., 2].max()
    level = low + _UPPER_SHARE * (high - low)
    corners = corners[side * thing.corners[..., 0].mean(axis=1) >= 0.0]
    upper, behind = (
        some[some[..., 2].min(axis=1) > level] @ _BACKWARDS.T
        for some in (corners, seat.shape.corners)
    )
    gap = -rest_on(behind, upper) if len(upper) and len(behind) else np.inf
    return float(gap) if np.isfinite(gap) else None


def drop(
    seat: Seat, thing: PosedObject, key: str, rng: np.random.Generator
) -> tuple[Item, Pose] | None:  # fmt: skip
    """A thing that lies on a seat, somewhere and turned in some way."""
    x0, x1, y0, y1 = seat.reach
    yaw = float(rng.uniform(-35.0, 35.0)) + 180.0 * float(rng.integers(2))
    points = thing.skin @ about_z(np.radians(yaw)).T
    half = 0.5 * (points.max(axis=0) - points.min(axis=0))
    if x1 - x0 < 2 * half[0] or y1 - y0 < 2 * half[1]:
        return None
    x = rng.uniform(x0 + half[0], x1 - half[0], 8)
    y = rng.uniform(y0 + half[1], y1 - half[1], 8)
    z = seat.relief.rest(points, x, y)
    best = int(np.argmin(z))
    place = (float(x[best]), float(y[best]), yaw)
    return _laid(seat, thing, key, points, place)


def _laid(
    seat: Seat, thing: PosedObject, key: str, points: Array, place: Pose
) -> tuple[Item, Pose] | None:
    x, y, yaw = place
    z = rest_on(seat.shape.corners, thing.above(place))
    base = points[points[:, 2] < points[:, 2].min() + _LOWEST_M]
    gap = base[:, 2] + z - seat.relief.at(x + base[:, 0], y + base[:, 1])
    if not np.isfinite(z) or gap.max() > _MAX_GAP_M:
        return None
    size, style = thing.make
    rx, ry = placed(seat.pose, x, y)
    turn = round(wrapped(seat.pose[2] + yaw), 2)
    height = round(seat.carrier.z + z, 4)
    item = Item(
        key, thing.name, size, style, round(rx, 4), round(ry, 4), height, turn, seat.carrier.key,
        True, tilt=thing.tilt, lies=True,
    )  # fmt: skip
    return item, (x, y, yaw)
