"""Level boards and tops of an object, found on its meshes: where they are free, and how high.

Vertical lines through the middles of cells meet the object's triangles. Where a line leaves the
solid upwards, something may stand. The free height ends at what the line meets next, and at every
triangle edge that passes through the cell. Walls and rims that are thinner than a cell slip between
the lines, but have edges.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.generation.shapes import BuiltForm

CELL_M: Final = 0.01
# Lines keep off the planes at round numbers in which edges of furniture lie, metres.
_OFF_M: Final = 0.00037
# Tops within this of each other are one level, metres; what rises less is not an obstacle.
_LEVEL_M: Final = 0.0008
# The cosine of what still counts as level.
_UPRIGHT: Final = 0.9998
# The cosine of what is as good as upright.
_STEEP: Final = 0.05
_LEAST_AREA_M2: Final = 0.004
# A board with less above it holds nothing, metres.
_LEAST_HEADROOM_M: Final = 0.03
# What is seen from the front when it is looked at along so many heights above a board, metres.
_LOOKS_M: Final = (0.02, 0.05, 0.09, 0.14)
# Doors with panes have opaque frames, and ledges that are not boards; metres.
_ABOVE_FRAMES_M: Final = _LOOKS_M[2:]
_DEEP_M: Final = 0.12
# A board is open where a look from the front comes this far beyond its front edge, metres, and as
# a whole where that is so for this share of its width.
_SEEN_M: Final = 0.04
_OPEN_SHARE: Final = 0.15


@dataclass(frozen=True, eq=False)
class Level:
    """A level top or board of an object, in its own frame.

    Attributes:
        z: Its height above the object's base, metres.
        origin: (2,) the least corner of the first cell, metres.
        clear: (H, W) how high things may be that stand in a cell, metres; 0 where there is no top.
        open: Whether it is seen from the front or from above.
        glazed: Whether that is so through a pane alone.
    """

    z: float
    origin: Array
    clear: Array
    open: bool
    glazed: bool = False

    @property
    def area(self) -> float:
        """Square metres that are free."""
        return float((self.clear > 0.0).sum()) * CELL_M**2

    @property
    def headroom(self) -> float:
        """How high things may be on most of it, metres; infinite on tops."""
        return float(np.median(self.clear[self.clear > 0.0]))

    def within(self, x: Array, y: Array) -> Array:
        """(...) how high things may be at places, metres; 0 beside it."""
        i = np.floor((x - self.origin[0]) / CELL_M).astype(int)
        j = np.floor((y - self.origin[1]) / CELL_M).astype(int)
        height, width = self.clear.shape
        there = (i >= 0) & (i < width) & (j >= 0) & (j < height)
        found: Array = np.where(
            there, self.clear[np.clip(j, 0, height - 1), np.clip(i, 0, width - 1)], 0.0
        )
        return found


def levels_of(shape: BuiltForm) -> tuple[Level, ...]:
    """The levels of an object, the lowest first."""
    corners = shape.corners
    low = corners.reshape(-1, 3).min(axis=0)[:2] - _OFF_M
    high = corners.reshape(-1, 3).max(axis=0)[:2]
    columns, rows = (np.floor((high - low) / CELL_M).astype(int) + 1).tolist()
    cell, z, up = crossings(corners, low, columns, rows)
    tops, roof = _tops(cell, z, up)
    passed, ends, which = edge_cells(corners, low, columns)
    walls = _walls(corners, passed, which)
    found = []
    for height, cells in _grouped(tops):
        clear = np.zeros(rows * columns)
        clear[cells] = np.inf
        for others, heights in (roof, (passed, ends)):
            above = (heights > height + _LEVEL_M) & (clear[others] > 0.0)
            np.minimum.at(clear, others[above], heights[above] - height)
        where, foot, head = walls
        clear[where[(foot < height + _LEVEL_M) & (head > height + _LEVEL_M)]] = 0.0
        level = clear.reshape(rows, columns)
        if (level > _LEAST_HEADROOM_M).sum() * CELL_M**2 >= _LEAST_AREA_M2:
            found.append(_visible_level(height, level, low, shape))
    return tuple(found)


def _visible_level(height: float, clear: Array, low: Array, shape: BuiltForm) -> Level:
    """A level, seen from the front or through panes there."""
    level = _reachable_level(height, clear.copy(), low, shape.corners)
    deep = int((clear > 0.0).any(axis=1).sum()) * CELL_M
    if level.open or deep < _DEEP_M or shape.opaque is shape.corners:
        return level
    return replace(_reachable_level(height, clear, low, shape.opaque, _ABOVE_FRAMES_M), glazed=True)


def crossings(
    corners: Array, low: Array, columns: int, rows: int, side: float = CELL_M
) -> tuple[Ints, Array, Array]:
    """Where the vertical lines meet the triangles: cell, height, and the normal's z."""
    a, b, c = np.moveaxis(corners, 1, 0)
    e, f = b - a, c - a
    normal = np.cross(e, f)
    steep = np.abs(normal[:, 2]) < 1e-12
    first = np.ceil((corners[..., :2].min(axis=1) - low) / side - 0.5).astype(int)
    last = np.floor((corners[..., :2].max(axis=1) - low) / side - 0.5).astype(int)
    first, last = np.maximum(first, 0), np.minimum(last, [columns - 1, rows - 1])
    counts = np.maximum(last - first + 1, 0)
    each = np.where(steep, 0, counts[:, 0] * counts[:, 1])
    t = np.repeat(np.arange(len(each)), each)
    k = np.arange(each.sum()) - np.repeat(np.cumsum(each) - each, each)
    i = first[t, 0] + k % np.maximum(counts[t, 0], 1)
    j = first[t, 1] + k // np.maximum(counts[t, 0], 1)
    px, py = low[0] + side * (i + 0.5) - a[t, 0], low[1] + side * (j + 0.5) - a[t, 1]
    area = normal[t, 2]
    v = (px * f[t, 1] - py * f[t, 0]) / area
    w = (e[t, 0] * py - e[t, 1] * px) / area
    hit = (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
    t, v, w = t[hit], v[hit], w[hit]
    z = a[t, 2] + v * e[t, 2] + w * f[t, 2]
    length = np.linalg.norm(normal, axis=1)
    return (j * columns + i)[hit], z, (normal[:, 2] / np.maximum(length, 1e-30))[t]


def _tops(cell: Ints, z: Array, up: Array) -> tuple[tuple[Ints, Array], tuple[Ints, Array]]:
    """Level places where a line leaves the last of all solids, and where it enters any."""
    order = np.lexsort((up > 0.0, np.round(z, 5), cell))
    cell, z, up = cell[order], z[order], up[order]
    # Solids that a line is in after each crossing: parts may lie within each other.
    depth = np.cumsum(np.where(up > 0.0, -1, 1))
    starts = np.flatnonzero(np.diff(cell, prepend=-1))
    counts = np.diff(np.append(starts, len(cell)))
    before = np.where(starts > 0, depth[starts - 1], 0)
    depth = depth - np.repeat(before, counts)
    out = (up > 0.0) & (depth <= 0)
    level = out & (up > _UPRIGHT)
    return (cell[level], z[level]), (cell, z)


def _grouped(tops: tuple[Ints, Array]) -> list[tuple[float, Ints]]:
    """Heights at which there is enough of a level top, the lowest first, and its cells."""
    cells, z = tops
    least = _LEAST_AREA_M2 / CELL_M**2
    heights, counts = np.unique(np.round(z, 4), return_counts=True)
    found: dict[float, Ints] = {}
    for height in heights[np.argsort(-counts, kind="stable")][: (counts >= least).sum()].tolist():
        exact = float(z[np.abs(z - height) < 1e-4].max())
        if all(abs(exact - other) > 2 * _LEVEL_M for other in found):
            found[exact] = np.unique(cells[np.abs(z - exact) < _LEVEL_M])
    return sorted(found.items())


def edge_cells(
    corners: Array, low: Array, columns: int, side: float = CELL_M
) -> tuple[Ints, Array, Ints]:
    """Cells through which edges of triangles pass, how high they are there, and whose they are."""
    ends = np.roll(corners, -1, axis=1).reshape(-1, 3)
    starts = corners.reshape(-1, 3)
    steps = np.ceil(np.linalg.norm((ends - starts)[:, :2], axis=1) / (0.5 * side)).astype(int) + 1
    t = np.repeat(np.arange(len(steps)), steps)
    k = np.arange(steps.sum()) - np.repeat(np.cumsum(steps) - steps, steps)
    share = k / np.maximum(steps[t] - 1, 1)
    points = starts[t] + share[:, None] * (ends - starts)[t]
    # Of upright edges the whole height counts: both ends are there, and what is between them is
    # above the lower one.
    i, j = np.floor((points[:, :2] - low) / side).astype(int).T
    return j * columns + i, points[:, 2], t // 3


def _walls(corners: Array, cells: Ints, which: Ints) -> tuple[Ints, Array, Array]:
    """Cells through which upright faces pass, and where these begin and end, metres.

    Lines through the middles of cells miss them, and their edges may be far above and below.
    """
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    upright = np.abs(normal[:, 2]) < _STEEP * np.linalg.norm(normal, axis=1)
    walls = upright[which]
    z = corners[which[walls], :, 2]
    return cells[walls], z.min(axis=1), z.max(axis=1)


def along_edges(corners: Array, step: float = CELL_M) -> Array:
    """(N, 3) points along all edges of triangles, no farther apart than a step; metres."""
    starts, ends = corners.reshape(-1, 3), np.roll(corners, -1, axis=1).reshape(-1, 3)
    steps = np.ceil(np.linalg.norm(ends - starts, axis=1) / step).astype(int) + 1
    t = np.repeat(np.arange(len(steps)), steps)
    k = np.arange(steps.sum()) - np.repeat(np.cumsum(steps) - steps, steps)
    return np.asarray(starts[t] + (k / np.maximum(steps[t] - 1, 1))[:, None] * (ends - starts)[t])


def _reachable_level(
    height: float, clear: Array, low: Array, corners: Array, heights: Sequence[float] = _LOOKS_M
) -> Level:
    """A level: of a board that is open to the front only what can be seen, and reached, counts."""
    free = clear > 0.0
    if np.isinf(clear[free]).mean() > 0.5:
        return Level(height, low, clear, True)
    columns = np.flatnonzero(free.any(axis=0))
    x = low[0] + CELL_M * (columns + 0.5)
    edge = low[1] + CELL_M * np.argmax(free[:, columns], axis=0)
    room = float(np.median(clear[free]))
    looks = [height + look for look in heights if look < 0.8 * room] or [height + 0.5 * room]
    seen = np.array([_first_met(corners, x, z) > edge + _SEEN_M for z in looks]).all(axis=0)
    if seen.mean() < _OPEN_SHARE:
        return Level(height, low, clear, False)
    clear[:, columns[~seen]] = 0.0
    return Level(height, low, clear, True)


def _first_met(corners: Array, x: Array, z: float) -> Array:
    """(N,) y where lines that come from the front at some x and a height meet the object first."""
    near = (corners[..., 2].min(axis=1) <= z) & (corners[..., 2].max(axis=1) >= z)
    a, b, c = np.moveaxis(corners[near], 1, 0)
    e, f = b - a, c - a
    px, pz = x[:, None] - a[:, 0], z - a[:, 2]
    area = e[:, 0] * f[:, 2] - e[:, 2] * f[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        v = (px * f[:, 2] - pz * f[:, 0]) / area
        w = (e[:, 0] * pz - e[:, 2] * px) / area
        hit = (area != 0.0) & (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
        y = np.where(hit, a[:, 1] + v * e[:, 1] + w * f[:, 1], np.inf)
    return np.asarray(y.min(axis=1, initial=np.inf))
