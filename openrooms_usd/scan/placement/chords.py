"""Chords of solids: intervals of parallel lines inside, by which penetration is measured.

The chords of two bodies on the same lines tell for all shifts along these lines at once whether
the bodies overlap: chords [a0, a1] and [b0, b1] overlap at shift t if b0 - a1 < t < b1 - a0. Bodies
need not be convex: a chair may stand under a table.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array

Numbers = NDArray[np.int64]

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

    line: Numbers
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
    kept = (sides.min(axis=1) < lattice.high).all(axis=1)
    kept &= (sides.max(axis=1) > lattice.low).all(axis=1)
    return np.asarray(triangles[kept])


def _crossings(local: Array, lattice: Lattice) -> tuple[Numbers, Array, Numbers]:
    """Line, place along it, and +1 where it enters a surface or -1 where it leaves one.

    Triangles are scan-converted to rows, and rows to lines; both half-open, so that a line through
    a common edge intersects one of two triangles.
    """
    plan = (local[..., 1:] - lattice.corner) / lattice.spacing
    width, rows = lattice.shape
    first, last = _whole(plan[..., 1].min(axis=1), plan[..., 1].max(axis=1), rows)
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


def _whole(low: Array, high: Array, count: int) -> tuple[Numbers, Numbers]:
    """Integer bounds, half-open and clipped to 0 .. count, of half-open ranges."""
    first, last = np.ceil(low), np.ceil(high)
    return (np.clip(first, 0, count).astype(np.int64), np.clip(last, 0, count).astype(np.int64))


def _counted(first: Numbers, last: Numbers) -> tuple[Numbers, Numbers]:
    """All integers of ranges: the number of the range, and the integer."""
    counts = np.maximum(last - first, 0)
    owner = np.repeat(np.arange(len(first)), counts)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, first[owner] + number


def _spans(plan: Array, along: Array, row: Numbers) -> tuple[Array, Array]:
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


def paired(a: Chords, b: Chords) -> tuple[Numbers, Numbers]:
    """All pairs of the chords of two bodies on the same line, as rows."""
    start = np.searchsorted(b.line, a.line, side="left")
    stop = np.searchsorted(b.line, a.line, side="right")
    return _counted(start, stop)
