"""Proposals for openings in one wall: maximum-sum rectangles of its evidence grid.

Every cell has a weight, positive as evidence of an opening; the maximum-sum rectangle is proposed
and removed, again and again. Occluded cells have nearly no weight, so that furniture before a wall
neither makes a hole nor splits one.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from scipy import ndimage

from openrooms_usd.arrays import Array
from openrooms_usd.scan.openings.cellcounts import (
    BLINDS,
    CELL_M,
    CURTAIN,
    DOOR,
    WINDOW,
    WINDOWS_CELLS,
)
from openrooms_usd.scan.openings.rectangles import Rectangle, best_rectangle, ring
from openrooms_usd.scan.openings.wallpicture import WallGrid

Kind = Literal["door", "window"]

LABELS: Final[dict[Kind, int]] = {"door": DOOR, "window": WINDOW}

# Weights of cells where the wall returned, and where nothing is known.
_SOLID_WEIGHT: Final = -1.0
HIDDEN_WEIGHT: Final = -0.03
# Wall over this part of a rectangle's height, and so wide, metres, separates two openings.
_PARTING_SHARE_AND_M: Final = (0.7, 0.18)
# Two rectangles replace one if their sum is larger by this, square metres, and their gap is wider
# than a mullion, metres.
_SECOND_AREA_M2: Final = 0.1
_MULLION_M: Final = 0.12
_MIN_WIDTH_M: Final = 0.25
_MIN_AREA_M2: Final = 0.07
_MAX_PROPOSALS: Final = 10
# Width of the strips of wall around a rectangle, metres.
_WALL_AROUND_M: Final = 0.075
# Width of the surroundings in which furniture is looked for, metres.
_SURROUNDINGS_M: Final = 0.3
# Heights of a walking body, metres, and the share of them that blocks its way.
_BODY_M: Final = (0.3, 1.5)
_BLOCKING_SHARE: Final = 0.12
# Probability that a cell without evidence is wall, beside an opening and above it.
_MAY_BE_WALL_SHARE: Final = {"beside": 0.5, "top": 0.42}
# Holes that begin below the first height are doors, above the sill windows; between, the evidence
# below them decides, metres.
_DOOR_STEP_M: Final = 0.06
# Passages may have thresholds of up to 12 cm, where floor was seen behind them and the headroom
# suffices; holes seem to begin up to 5 cm higher than they do.
_MAX_THRESHOLD_M: Final = 0.12 + 0.05
_MIN_HEADROOM_M: Final = 1.8
# Greatest width and height of a usual door, metres.
_DOOR_SIZE_M: Final = (1.3, 2.35)
_MIN_SILL_M: Final = 0.45


@dataclass(frozen=True)
class Proposal:
    """A rectangle that may be an opening, with its evidence as shares from 0 to 1.

    Attributes:
        kind: Of the opening.
        where: Its cells.
        label: Share of the labelled returns that have the kind's label.
        hole: Share of its cells with returns from behind the plane, or none.
        recess: Share of its cells with returns from behind the plane.
        solid: Share of its cells where the wall returned.
        curtain: Share of its cells behind a curtain.
        framed: Share of the strips around it where the wall returned; the least of its sides.
        threshold: Share of its width where floor was seen behind the plane.
        leaf: Score of a closed leaf with its frame.
        walled: As ``framed``; the mean of its sides.
        beyond: Share of its cells through which something was seen far behind the wall.
        clutter: Share of a wider strip around it where things before the wall hide it.
        blocked: Share of its width before which something stands at the height of a body.
        headroom: From its upper edge to the top of the wall, metres.
    """

    kind: Kind
    where: Rectangle
    label: float = 0.0
    hole: float = 0.0
    recess: float = 0.0
    solid: float = 0.0
    curtain: float = 0.0
    framed: float = 0.0
    threshold: float = 0.0
    leaf: float = 0.0
    walled: float = 0.0
    beyond: float = 0.0
    clutter: float = 0.0
    blocked: float = 0.0
    headroom: float = 0.0

    @property
    def width(self) -> float:
        """Metres."""
        return CELL_M * (self.where.right - self.where.left)

    @property
    def height(self) -> float:
        """Metres."""
        return CELL_M * (self.where.top - self.where.bottom)

    @property
    def sill(self) -> float:
        """Height of its lower edge above the floor, metres."""
        return CELL_M * self.where.bottom


def hole_weights(grid: WallGrid) -> Array:
    """(Z, X) weights by geometry."""
    weights = np.where(grid.solid, _SOLID_WEIGHT, np.where(grid.recess, 1.0, grid.void))
    unknown = ~grid.solid & ~grid.recess & (grid.void == 0)
    return np.asarray(np.where(unknown, HIDDEN_WEIGHT, weights))


def rectangles(weights: Array, height: float = 0.0) -> Iterator[Rectangle]:
    """Maximum-sum rectangles, one after the other, disjoint.

    Args:
        weights: (Z, X) positive as evidence of an opening.
        height: Least height, metres.
    """
    weights = weights.copy()
    for _ in range(_MAX_PROPOSALS):
        found, value = _one(weights, max(1, round(height / CELL_M)))
        if value * CELL_M**2 < _MIN_AREA_M2:
            return
        yield found
        grown = Rectangle(
            max(found.bottom - 2, 0), found.top + 2, max(found.left - 2, 0), found.right + 2
        )
        inside = weights[grown.rows, grown.columns]
        np.minimum(inside, _SOLID_WEIGHT, out=inside)


def _one(weights: Array, least_rows: int) -> tuple[Rectangle, float]:
    """The best rectangle, or the better one of two that have a larger sum together."""
    whole, value = _unparted(weights, least_rows)
    found, most = (whole, value), value + _SECOND_AREA_M2 / CELL_M**2
    for halves in _halves(whole, len(weights), least_rows):
        pair = [_within(weights, half, least_rows) for half in halves]
        together = sum(part for _, part in pair)
        if together > most and _are_two(pair[0][0], pair[1][0], whole):
            most, found = together, max(pair, key=lambda one: one[1])
    return found


def _halves(whole: Rectangle, rows: int, least_rows: int) -> Iterator[tuple[Rectangle, Rectangle]]:
    """Pairs of regions for two rectangles: beside a vertical cut, or above each other."""
    least = round(_MIN_WIDTH_M / CELL_M)
    for column in range(whole.left + least, whole.right - least + 1, 2):
        yield (Rectangle(0, rows, whole.left, column), Rectangle(0, rows, column, whole.right))
    least = max(least, least_rows)
    for row in range(whole.bottom + least, whole.top - least + 1, 2):
        yield replace(whole, top=row), replace(whole, bottom=row)


def _are_two(first: Rectangle, second: Rectangle, whole: Rectangle) -> bool:
    if second.left < first.right:
        return (second.bottom - first.top) * CELL_M >= _MULLION_M
    beside = all(
        min(one.top, whole.top) - max(one.bottom, whole.bottom) > (whole.top - whole.bottom) // 2
        for one in (first, second)
    )
    return beside and (second.left - first.right) * CELL_M >= _MULLION_M


def _within(weights: Array, half: Rectangle, least_rows: int) -> tuple[Rectangle, float]:
    """The best rectangle in a part of the grid."""
    found, value = best_rectangle(weights[half.rows, half.columns], least_rows)
    low, left = half.bottom, half.left
    moved = (found.bottom + low, found.top + low, found.left + left, found.right + left)
    return Rectangle(*moved), value


def _unparted(weights: Array, least_rows: int) -> tuple[Rectangle, float]:
    """The best rectangle that no wall divides from its lower to its upper edge."""
    share, width = _PARTING_SHARE_AND_M
    tried = weights.copy()
    while True:
        found, value = best_rectangle(tried, least_rows)
        standing = (weights[found.rows, found.columns] < -0.3).mean(axis=0) > share
        runs, count = ndimage.label(standing)
        lengths = np.bincount(runs)[1:] * CELL_M
        broad = np.flatnonzero(lengths >= width) + 1
        if value <= 0 or not count or not len(broad):
            return found, value
        columns = found.left + np.flatnonzero(np.isin(runs, broad))
        tried[:, columns] = -1e3


def measured(grid: WallGrid, kind: Kind, where: Rectangle) -> Proposal:
    """The evidence for an opening in a rectangle of a wall."""
    solid, recess = grid.solid[where.rows, where.columns], grid.recess[where.rows, where.columns]
    hole = np.maximum(recess, grid.void[where.rows, where.columns])
    votes, curtain = 0.0, 0.0
    if grid.labels:
        named, labelled = (
            float(counts[where.rows, where.columns].sum())
            for counts in (grid.labels[LABELS[kind]], grid.labelled)
        )
        veil = (grid.labels[CURTAIN] + grid.labels[BLINDS])[where.rows, where.columns]
        votes = named / max(labelled - float(veil.sum()), 1.0)
        curtain = float((veil > 0).mean())
    sides = _framing(grid, where, kind)
    return Proposal(
        kind,
        where,
        label=votes,
        hole=float(hole.mean()),
        recess=float(recess.mean()),
        solid=float(solid.mean()),
        curtain=curtain,
        framed=min(sides),
        threshold=float(grid.threshold[where.columns].mean()),
        walled=float(np.mean(sides)),
        beyond=float(grid.beyond[where.rows, where.columns].mean()),
        clutter=_clutter(grid, where, kind),
        blocked=_blocked(grid, where),
        headroom=CELL_M * (len(grid.solid) - where.top),
    )


def _sides(kind: Kind) -> tuple[str, ...]:
    return ("left", "right", "top") + (("bottom",) if kind == "window" else ())


def _clutter(grid: WallGrid, where: Rectangle, kind: Kind) -> float:
    strips = ring(grid.shape, where, round(_SURROUNDINGS_M / CELL_M))
    hidden = grid.before & ~grid.solid
    parts = [hidden[s.rows, s.columns].ravel() for side in _sides(kind) if (s := strips.get(side))]
    return float(np.concatenate(parts).mean()) if parts else 0.0


def _blocked(grid: WallGrid, where: Rectangle) -> float:
    low, high = (round(height / CELL_M) for height in _BODY_M)
    standing = grid.before[low:high, where.columns].mean(axis=0)
    return float((standing > _BLOCKING_SHARE).mean())


def _framing(grid: WallGrid, where: Rectangle, kind: Kind) -> list[float]:
    """The part of the strip on each side of a rectangle where the wall returned, or may have."""
    # Where returns are counted in wide windows a hole seems smaller than it is.
    apart = (grid.window - WINDOWS_CELLS[0]) // 2
    outer = Rectangle(
        max(where.bottom - apart, 0),
        min(where.top + apart, grid.shape[0]),
        max(where.left - apart, 0),
        min(where.right + apart, grid.shape[1]),
    )
    strips = ring(grid.shape, outer, round(_WALL_AROUND_M / CELL_M))
    hidden = ~grid.solid & ~grid.recess & (grid.void == 0)
    parts = []
    for side in _sides(kind):
        known = grid.solid + _MAY_BE_WALL_SHARE["top" if side == "top" else "beside"] * hidden
        strip = strips.get(side)
        parts.append(float(known[strip.rows, strip.columns].mean()) if strip else 0.0)
    return parts


def kind_of(grid: WallGrid, where: Rectangle) -> Kind:
    """Whether a hole is a door or a window, by the height of its lower edge."""
    # Counted in wide windows, what lies on the floor reaches up into a hole.
    sill = (where.bottom - (grid.window - WINDOWS_CELLS[0]) // 2) * CELL_M
    tall = (where.top - where.bottom) * CELL_M
    wide = (where.right - where.left) * CELL_M
    walked = grid.threshold[where.columns].mean() > 0.5 and tall > _MIN_HEADROOM_M
    # A low sill can be told from a floor in dense scans alone: else a door's size decides.
    sized = _MIN_HEADROOM_M < tall < _DOOR_SIZE_M[1] and wide < _DOOR_SIZE_M[0]
    sized &= grid.window > WINDOWS_CELLS[0]
    if sill < _DOOR_STEP_M or (sill < _MAX_THRESHOLD_M and (walked or sized)):
        return "door"
    below = grid.solid[: where.bottom, where.columns]
    return "window" if where.bottom * CELL_M >= _MIN_SILL_M or below.mean() > 0.5 else "door"
