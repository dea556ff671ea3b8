"""Translational penetration depth of two bodies, and its directions.

The depth along a direction is the least shift along it that separates the bodies; that of the pair
is the least over the normals of both bodies' sides, and up and down. It is measured on the meshes,
by chords on common lines.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.scan.placement.bodies import Body, greatest, least

# Chords of solids: intervals of parallel lines inside, by which penetration is measured.
#
# The chords of two bodies on the same lines show whether the bodies overlap, for all shifts along
# these lines at once. Chords [a0, a1] and [b0, b1] overlap at shift t if b0 - a1 < t < b1 - a0.
# Bodies need not be convex: a chair may stand under a table.


_MIN_SPACING_M: Final = 0.003
# Slope of the rows of lines, and offset between successive rows in spacings: irrational, so that
# thin axis-aligned boards are not missed between lines.
_ROW_SLOPE: Final = 0.3247179572447461
_ROW_OFFSET: Final = 0.6180339887498949


@dataclass(frozen=True, eq=False)
class Lattice:
    """A lattice of parallel lines over a rectangle, in rows.

    Attributes:
        low: (2,) least coordinates of the rectangle, metres.
        high: (2,) its greatest.
        axes: (3, 3) columns: directions of the lines, of the rows, and across the rows.
        corner: (2,) least coordinates along and across the rows, metres.
        spacing: Between lines, metres.
        shape: Lines a row, and rows.
    """

    low: Array
    high: Array
    axes: Array
    corner: Array
    spacing: float
    shape: tuple[int, int]

    @classmethod
    def over(cls, low: Array, high: Array, count: int) -> "Lattice":
        """About ``count`` lines along the first axis, through a rectangle of the other two.

        Args:
            low: (2,) its least coordinates, metres.
            high: (2,) its greatest.
            count: Number of lines; fewer where they would be nearer than 3 mm.
        """
        spacing = max(_MIN_SPACING_M, float(np.sqrt(np.prod(high - low) / count)))
        # Rows along the short side: slanted rows then leave the rectangle the least.
        short, long = np.argsort(high - low, kind="stable")
        axes = np.eye(3)
        across = axes[1 + long] + _ROW_SLOPE * axes[1 + short]
        width = float(high[short] - low[short])
        size = np.array([width, high[long] - low[long] + _ROW_SLOPE * width])
        shape = np.maximum(np.ceil(size / spacing), 1).astype(int)
        corner = np.array([low[short], low[long] + _ROW_SLOPE * low[short]])
        slanted = np.stack([axes[0], axes[1 + short], across], axis=1)
        return cls(low, high, slanted, corner, spacing, (int(shape[0]), int(shape[1])))


@dataclass(frozen=True, eq=False)
class Chords:
    """Intervals of lines inside a solid, sorted by line and along it.

    Attributes:
        line: (C,) numbers of lines, ascending.
        low: (C,) beginnings, metres along the line.
        high: (C,) ends, metres along the line.
    """

    line: Ints
    low: Array
    high: Array

    def within(self, low: float, high: float) -> "Chords":
        """Those that intersect an interval."""
        kept = (self.high > low) & (self.low < high)
        return Chords(self.line[kept], self.low[kept], self.high[kept])


def chords(triangles: Array, lattice: Lattice) -> Chords:
    """The chords of closed surfaces, which may overlap each other, on a lattice's lines.

    Args:
        triangles: (T, 3, 3) counter-clockwise from outside, metres, in the frame of the lattice.
        lattice: The lines.
    """
    line, place, step = _crossings(_concerned(triangles, lattice) @ lattice.axes, lattice)
    order = np.lexsort((-step, place, line))
    line, place, step = line[order], place[order], step[order]
    # Rounding may count an edge on a line twice or not at all: such lines are dropped.
    sums = np.bincount(line, step, minlength=lattice.shape[0] * lattice.shape[1])
    sound = sums[line] == 0
    line, place, step = line[sound], place[sound], step[sound]
    after = np.cumsum(step)
    begins = (after > 0) & (after - step <= 0)
    ends = (after <= 0) & (after - step > 0)
    return Chords(line[begins], place[begins], place[ends])


def _concerned(triangles: Array, lattice: Lattice) -> Array:
    """The triangles that may intersect lines."""
    sides = triangles[..., 1:]
    kept = (least(sides) < lattice.high) & (greatest(sides) > lattice.low)
    return np.asarray(triangles[kept[:, 0] & kept[:, 1]])


def _crossings(local: Array, lattice: Lattice) -> tuple[Ints, Array, Ints]:
    """Line, place along it, and +1 where it enters a surface or -1 where it leaves one.

    Triangles are scan-converted to rows, and rows to lines; both half-open, so that a line through
    a common edge intersects one of two triangles.
    """
    plan = (local[..., 1:] - lattice.corner) / lattice.spacing
    width, rows = lattice.shape
    first, last = _whole(least(plan[..., 1]), greatest(plan[..., 1]), rows)
    e, f = plan[:, 1] - plan[:, 0], plan[:, 2] - plan[:, 0]
    area = e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]
    face, row = _counted(first, np.where(area != 0.0, last, first))
    left, right = _spans(plan[face], local[face, :, 0], row)
    offset = (_ROW_OFFSET * row) % 1.0
    first, last = _whole(left[0] - offset, right[0] - offset, width)
    span, column = _counted(first, last)
    t = (column + offset[span] - left[0][span]) / (right[0] - left[0])[span]
    place = left[1][span] + t * (right[1] - left[1])[span]
    step = np.where(area[face[span]] < 0.0, 1, -1)
    # The orientation depends on the side of the rectangle that the rows run along.
    step = step * np.sign(np.linalg.det(lattice.axes)).astype(np.int64)
    return row[span] * width + column, place, step


def _whole(low: Array, high: Array, count: int) -> tuple[Ints, Ints]:
    """Integer bounds, half-open and clipped to 0 .. count, of half-open ranges."""
    first, last = np.ceil(low), np.ceil(high)
    return (np.clip(first, 0, count).astype(np.int64), np.clip(last, 0, count).astype(np.int64))


def _counted(first: Ints, last: Ints) -> tuple[Ints, Ints]:
    """All integers of ranges: the number of the range, and the integer."""
    counts = np.maximum(last - first, 0)
    owner = np.repeat(np.arange(len(first)), counts)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, first[owner] + number


def _spans(plan: Array, along: Array, row: Ints) -> tuple[Array, Array]:
    """(2, R) each: coordinates along rows and lines where rows enter and leave triangles."""
    ends = np.empty((3, 2, len(row)))
    above = plan[..., 1] > row[:, None]
    for edge, (i, j) in enumerate(((0, 1), (1, 2), (0, 2))):
        cut = above[:, i] != above[:, j]
        rise = np.where(cut, plan[:, j, 1] - plan[:, i, 1], 1.0)
        t = np.where(cut, (row - plan[:, i, 1]) / rise, np.nan)
        ends[edge, 0] = plan[:, i, 0] + t * (plan[:, j, 0] - plan[:, i, 0])
        ends[edge, 1] = along[:, i] + t * (along[:, j] - along[:, i])
    # Each row intersects two edges of its triangle.
    one = np.where(np.isnan(ends[0]), ends[1], ends[0])
    two = np.where(np.isnan(ends[2]), ends[1], ends[2])
    forth = one[0] <= two[0]
    return np.where(forth, one, two), np.where(forth, two, one)


def paired(a: Chords, b: Chords) -> tuple[Ints, Ints]:
    """All pairs of the chords of two bodies on the same line, as rows."""
    start = np.searchsorted(b.line, a.line, side="left")
    stop = np.searchsorted(b.line, a.line, side="right")
    return _counted(start, stop)


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
    low = np.maximum(least(mine).min(axis=0), least(theirs).min(axis=0))[1:]
    high = np.minimum(greatest(mine).max(axis=0), greatest(theirs).max(axis=0))[1:]
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
