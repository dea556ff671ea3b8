"""The outline of a room as the lines of its walls, and its greedy simplification by cost."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array

# Least angle at which neighbouring walls may meet in a corner, degrees.
_SAME_WALL_DEG: Final = 6.0
# Neighbours that meet at less than this may be one wall, degrees.
_MAYBE_SAME_WALL_DEG: Final = 15.0
_MAX_DROPPED_WALLS: Final = 3


@dataclass(frozen=True, eq=False)
class Outline:
    """A polygon as the lines of its walls.

    Attributes:
        normals: (N, 2) unit, outwards.
        offsets: (N,) metres.
    """

    normals: Array
    offsets: Array

    def __len__(self) -> int:
        return len(self.offsets)

    def corners(self) -> Array:
        """(N, 2) intersections of wall i - 1 and wall i: the start of wall i."""
        before, earlier = np.roll(self.normals, 1, axis=0), np.roll(self.offsets, 1)
        n, c = self.normals, self.offsets
        cross = before[:, 0] * n[:, 1] - before[:, 1] * n[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            x = (earlier * n[:, 1] - c * before[:, 1]) / cross
            y = (before[:, 0] * c - n[:, 0] * earlier) / cross
        return np.column_stack([x, y])

    def without(self, rows: list[int]) -> "Outline":
        """The outline without some of its walls, whose neighbours then meet."""
        keep = np.setdiff1d(np.arange(len(self)), rows)
        return Outline(self.normals[keep], self.offsets[keep])

    def joined(self, i: int, j: int, start: Array, end: Array) -> "Outline":
        """The outline with two neighbours replaced by the straight wall between two places."""
        along = (end - start) / np.linalg.norm(end - start)
        normals, offsets = self.normals.copy(), self.offsets.copy()
        normals[i] = along[1], -along[0]
        offsets[i] = normals[i] @ start
        return Outline(normals, offsets).without([j])

    def same(self, other: "Outline") -> bool:
        """Whether another outline has the same walls."""
        return np.array_equal(self.normals, other.normals) and np.array_equal(
            self.offsets, other.offsets
        )

    def valid(self) -> bool:
        """Whether it is a simple counter-clockwise polygon whose walls run forwards."""
        import shapely

        if len(self) < 3:
            return False
        corners = self.corners()
        if not np.isfinite(corners).all() or np.abs(corners).max() > 1e3:
            return False
        run = np.roll(corners, -1, axis=0) - corners
        along = np.column_stack([-self.normals[:, 1], self.normals[:, 0]])
        if ((run * along).sum(axis=1) <= 0.0).any():
            return False
        return bool(shapely.LinearRing(corners).is_simple)


def outline_of(corners: Array) -> Outline:
    """The outline of counter-clockwise corners (N, 2); collinear ones are merged."""
    run = np.roll(corners, -1, axis=0) - corners
    length = np.linalg.norm(run, axis=1)
    kept = length > 1e-6
    run, start = run[kept] / length[kept, None], corners[kept]
    normals = np.column_stack([run[:, 1], -run[:, 0]])
    offsets = (normals * start).sum(axis=1)
    return _merged(Outline(normals, offsets))


def _merged(outline: Outline) -> Outline:
    """Collinear neighbours merged."""
    keep = []
    for i in range(len(outline)):
        before = i - 1
        straight = outline.normals[i] @ outline.normals[before] > np.cos(np.deg2rad(0.5))
        if not (straight and abs(outline.offsets[i] - outline.offsets[before]) < 1e-3):
            keep.append(i)
    return Outline(outline.normals[keep], outline.offsets[keep])


def simplified(outline: Outline, cost: Callable[[Outline], float]) -> Outline:
    """Drop walls, up to three in a row, as long as that lowers the cost.

    That removes bays, niches and piers (two sides and a back) and jogs (two walls).

    Args:
        outline: The first outline.
        cost: What an outline costs, corners included.
    """
    best = cost(outline)
    while len(outline) > 3:
        moves = [(cost(other), other) for other in _simpler(outline) if other.valid()]
        if not moves:
            break
        lowest = min(range(len(moves)), key=lambda i: moves[i][0])
        if moves[lowest][0] >= best:
            break
        best, outline = moves[lowest]
    return outline


def _simpler(outline: Outline) -> Iterator[Outline]:
    count = len(outline)
    corners = outline.corners()
    for i in range(count):
        j = (i + 1) % count
        if outline.normals[i] @ outline.normals[j] > np.cos(np.deg2rad(_MAYBE_SAME_WALL_DEG)):
            yield outline.joined(i, j, corners[i], corners[(j + 1) % count])
    for dropped in range(1, min(_MAX_DROPPED_WALLS, count - 3) + 1):
        for first in range(count):
            rows = [(first + i) % count for i in range(dropped)]
            yield from _meeting(outline, rows, (first - 1) % count, (first + dropped) % count)


def _meeting(outline: Outline, rows: list[int], before: int, after: int) -> Iterator[Outline]:
    turn = outline.normals[before] @ outline.normals[after]
    if abs(turn) < np.cos(np.deg2rad(_SAME_WALL_DEG)):
        yield outline.without(rows)
    elif turn > 0.0:
        yield outline.without([*rows, before])
        yield outline.without([*rows, after])
