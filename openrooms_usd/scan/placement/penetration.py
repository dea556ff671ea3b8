"""Translational penetration depth of two bodies, and its directions.

The depth along a direction is the least shift along it that separates the bodies; that of the pair
is the least over the normals of both bodies' sides, and up and down. It is measured on the meshes,
by chords on common lines.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.placement.bodies import Body
from openrooms_usd.scan.placement.chords import Chords, Lattice, chords, paired

COARSE_LINES: Final = 2000
FINE_LINES: Final = 8000
# Narrower gaps do not count as separated, metres.
_MIN_WAY_OUT_M: Final = 0.002
# Depths are clipped to this, metres: nothing is moved so far.
_MAX_WAY_OUT_M: Final = 0.6
# Directions within 5 degrees of each other are duplicates.
_SAME_DIRECTION_COS: Final = 0.9962


@dataclass(frozen=True, eq=False)
class Penetration:
    """Two bodies that overlap.

    Attributes:
        depth: The least shift that separates them, metres.
        ways: Horizontal unit directions (2,), and the first body's depth along each, metres.
    """

    depth: float
    ways: tuple[tuple[Array, float], ...]


def near(a: Body, b: Body, gap: float = 0.0) -> bool:
    """Whether the boxes around two bodies overlap by more than a negative gap, metres."""
    return bool((a.low < b.high + gap).all() and (b.low < a.high + gap).all())


def penetration(
    a: Body, b: Body, tolerance: float, lines: int = COARSE_LINES
) -> Penetration | None:
    """The penetration of two bodies; None where it is below the tolerance.

    Args:
        a: A body.
        b: Another one.
        tolerance: Metres.
        lines: Lines a direction, through the intersection of the bodies' boxes.
    """
    if not near(a, b, -tolerance):
        return None
    ways: list[tuple[Array, float]] = []
    depth = np.inf
    for direction in directions(a, b):
        back, ahead = exits(a, b, _frame(direction), lines)
        depth = min(depth, back, ahead)
        if depth <= tolerance:
            return None
        ways += [(direction, ahead), (-direction, back)]
    below, above = exits(a, b, np.roll(np.eye(3), 1, axis=0), lines)
    depth = min(depth, below, above)
    return Penetration(depth, tuple(ways)) if depth > tolerance else None


def exits(a: Body, b: Body, axes: Array, lines: int = COARSE_LINES) -> tuple[float, float]:
    """The shifts of the first body, backward and forward, that separate the two.

    Args:
        a: The body that moves.
        b: The other one.
        axes: (3, 3) rows: the direction, and two perpendicular to it.
        lines: Their number.

    Returns:
        Metres, both 0 where the bodies do not overlap.
    """
    begin, end = _merged(*_blocked(a, b, axes, lines))
    around = (begin < 0.0) & (end > 0.0)
    return (float(-begin[around][0]), float(end[around][0])) if around.any() else (0.0, 0.0)


def gaps(a: Body, b: Body, direction: Array, lines: int = COARSE_LINES) -> tuple[float, float]:
    """The shifts of the first body in the plan, backward and forward, until it touches the other.

    Args:
        a: The body that moves.
        b: The other one; it does not overlap the first.
        direction: (2,) unit.
        lines: Their number.

    Returns:
        Metres; infinite where they never touch.
    """
    begin, end = _merged(*_blocked(a, b, _frame(direction), lines))
    middle = 0.5 * (begin + end)
    back, ahead = -end[middle < 0.0].max(initial=-np.inf), begin[middle > 0.0].min(initial=np.inf)
    return max(float(back), 0.0), max(float(ahead), 0.0)


def directions(a: Body, b: Body) -> list[Array]:
    """Horizontal unit normals (2,) of the sides of two bodies, unique, the likely first."""
    found: list[Array] = []
    overlap = np.minimum(a.high, b.high)[:2] - np.maximum(a.low, b.low)[:2]
    # The direction of the least overlap first: it likely has the least depth.
    for direction in sorted([*a.axes, *b.axes], key=lambda d: float(np.abs(d) @ overlap)):
        if all(abs(float(direction @ other)) < _SAME_DIRECTION_COS for other in found):
            found.append(direction)
    return found


def _frame(direction: Array) -> Array:
    x, y = direction
    return np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])


def _blocked(a: Body, b: Body, axes: Array, lines: int) -> tuple[Array, Array]:
    """Beginnings and ends of the intervals of shifts at which some chords overlap."""
    mine, theirs = a.triangles @ axes.T, b.triangles @ axes.T
    low = np.maximum(mine.min(axis=(0, 1)), theirs.min(axis=(0, 1)))[1:]
    high = np.minimum(mine.max(axis=(0, 1)), theirs.max(axis=(0, 1)))[1:]
    if (high <= low).any():
        return np.zeros(0), np.zeros(0)
    lattice = Lattice.over(low, high, lines)
    return _shifts(chords(mine, lattice), chords(theirs, lattice))


def _shifts(a: Chords, b: Chords) -> tuple[Array, Array]:
    if not len(a.line) or not len(b.line):
        return np.zeros(0), np.zeros(0)
    a = a.within(b.low.min() - _MAX_WAY_OUT_M, b.high.max() + _MAX_WAY_OUT_M)
    b = b.within(a.low.min(initial=0.0) - _MAX_WAY_OUT_M, a.high.max(initial=0.0) + _MAX_WAY_OUT_M)
    i, j = paired(a, b)
    begin, end = b.low[j] - a.high[i], b.high[j] - a.low[i]
    matters = (begin < _MAX_WAY_OUT_M) & (end > -_MAX_WAY_OUT_M)
    return begin[matters], end[matters]


def _merged(begin: Array, end: Array) -> tuple[Array, Array]:
    """The union of intervals, gaps too narrow to count closed."""
    if not len(begin):
        return begin, end
    order = np.argsort(begin, kind="stable")
    begin, reach = begin[order], np.maximum.accumulate(end[order])
    # A new group begins where an interval starts beyond everything before it.
    starts = np.flatnonzero(np.append(True, begin[1:] > reach[:-1] + _MIN_WAY_OUT_M))
    return begin[starts], reach[np.append(starts[1:], len(begin)) - 1]
