"""Proposals for openings in one wall: rectangles of its picture in which much speaks for one.

Evidence gives every cell a weight, positive where an opening seems to be; the rectangle with the
largest sum of weights is proposed, taken out, and the next one looked for. What is hidden weighs
next to nothing, so that furniture before a wall neither makes a hole nor cuts one.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from openrooms_usd.scan.rectangles import Rectangle, best_rectangle, ring
from openrooms_usd.scan.wallgrid import CELL, WallGrid, usual_counts

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Kind = Literal["door", "window"]

# NYU40.
DOOR, WINDOW, BLINDS, CURTAIN = 8, 9, 13, 16
LABELS: Final[dict[Kind, int]] = {"door": DOOR, "window": WINDOW}
ASKED: Final = (DOOR, WINDOW, BLINDS, CURTAIN)

# Weights of cells: where the wall stands, and where nothing is known.
_SOLID: Final = -1.0
_HIDDEN: Final = -0.03
# Cells with this part of the usual number of labels are sure of them.
_ENOUGH: Final = 0.25
# So far apart are folds of a curtain, metres.
_FOLDS: Final = 0.2
# Looking through says less than a label, as a door may be seen through a window's place.
_THROUGH: Final = 0.6
# A wall that stands on this part of a rectangle's height, for so many metres, parts two openings.
_PARTING: Final = (0.7, 0.18)
_LEAST_AREA: Final = 0.07
_MOST: Final = 10
# How far around a rectangle its wall is looked for, metres.
_AROUND: Final = 0.075
# Boards around doors are up to so wide, and stand out at least so far, metres.
_CASING: Final = (0.1, 0.005)
# Doors end below this height, windows above that, metres; between, what stands below decides.
_STEP: Final = 0.06
_SILL: Final = 0.45


@dataclass(frozen=True)
class Proposal:
    """A rectangle that may be an opening, and what speaks for it: parts of it, from 0 to 1.

    Attributes:
        kind: What it may be.
        where: Its cells.
        label: Of the labelled returns, those that call it by its name.
        hole: Of its cells, those where something lies behind the plane, or nothing returned.
        recess: Of its cells, those where something lies behind the plane.
        solid: Of its cells, those where the wall stands.
        curtain: Of its cells, those before which a curtain hangs.
        framed: Of the wall around it, what stands; the least of its sides.
        threshold: Of its width, where floor was seen behind the plane.
        leaf: How clearly a closed leaf and its frame stand out.
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

    @property
    def width(self) -> float:
        """Metres."""
        return CELL * (self.where.right - self.where.left)

    @property
    def height(self) -> float:
        """Metres."""
        return CELL * (self.where.top - self.where.bottom)

    @property
    def sill(self) -> float:
        """Height of its lower edge above the floor, metres."""
        return CELL * self.where.bottom


def hole_weights(grid: WallGrid) -> Array:
    """(Z, X) what geometry says."""
    weights = np.where(grid.solid, _SOLID, np.where(grid.recess, 1.0, grid.void))
    unknown = ~grid.solid & ~grid.recess & (grid.void == 0)
    return np.asarray(np.where(unknown, _HIDDEN, weights))


def label_weights(grid: WallGrid, kind: Kind) -> Array:
    """(Z, X) what labels say, and where there are none, geometry."""
    votes, all_votes = (around(counts) for counts in (grid.labels[LABELS[kind]], grid.labelled))
    curtain = around(grid.labels[CURTAIN] + grid.labels[BLINDS])
    others = all_votes - curtain
    geometry = hole_weights(grid)
    geometry = np.where(geometry > 0, _THROUGH * geometry, geometry)
    # Between the folds that returned, others did not.
    hangs = ndimage.maximum_filter(curtain, round(_FOLDS / CELL)) > 0
    geometry = np.where(hangs, np.minimum(geometry, _HIDDEN), geometry)
    # Where few returns have a label, as strays in a hole, geometry is asked as well.
    enough = _ENOUGH * usual_counts(grid.labelled, all_votes)
    said = (2.0 * votes - others) / np.maximum(others, enough)
    return np.asarray(said + geometry * (1.0 - np.minimum(others / enough, 1.0)))


def around(counts: Array) -> Array:
    """(Z, X) means over a cell and its neighbours."""
    smooth = ndimage.uniform_filter(counts, 3, mode="nearest")
    return np.where(smooth < 1e-9, 0.0, smooth)


def rectangles(grid: WallGrid, weights: Array, height: float = 0.0) -> Iterator[Rectangle]:
    """The rectangles with the most weight, one after the other, none over another.

    Args:
        grid: The wall.
        weights: (Z, X) positive where an opening seems to be.
        height: Lower rectangles are not asked for, metres.
    """
    weights = weights.copy()
    for _ in range(_MOST):
        found, value = _unparted(weights, max(1, round(height / CELL)))
        if value * CELL**2 < _LEAST_AREA:
            return
        yield found
        grown = Rectangle(
            max(found.bottom - 2, 0), found.top + 2, max(found.left - 2, 0), found.right + 2
        )
        inside = weights[grown.rows, grown.columns]
        np.minimum(inside, _SOLID, out=inside)


def _unparted(weights: Array, least_rows: int) -> tuple[Rectangle, float]:
    """The best rectangle that no piece of wall divides from its lower to its upper edge."""
    share, width = _PARTING
    tried = weights.copy()
    while True:
        found, value = best_rectangle(tried, least_rows)
        standing = (weights[found.rows, found.columns] < -0.3).mean(axis=0) > share
        runs, count = ndimage.label(standing)
        lengths = np.bincount(runs)[1:] * CELL
        broad = np.flatnonzero(lengths >= width) + 1
        if value <= 0 or not count or not len(broad):
            return found, value
        columns = found.left + np.flatnonzero(np.isin(runs, broad))
        tried[:, columns] = -1e3


def measured(grid: WallGrid, kind: Kind, where: Rectangle) -> Proposal:
    """What speaks for an opening at some place of a wall."""
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
    return Proposal(
        kind,
        where,
        label=votes,
        hole=float(hole.mean()),
        recess=float(recess.mean()),
        solid=float(solid.mean()),
        curtain=curtain,
        framed=_framed(grid, where, kind),
        threshold=float(grid.threshold[where.columns].mean()),
    )


def _framed(grid: WallGrid, where: Rectangle, kind: Kind) -> float:
    strips = ring(grid.shape, where, round(_AROUND / CELL))
    sides = ("left", "right", "top") + (("bottom",) if kind == "window" else ())
    # What is hidden may be wall as well as not.
    known = grid.solid + 0.5 * (~grid.solid & ~grid.recess & (grid.void == 0))
    parts = [
        known[strips[side].rows, strips[side].columns].mean() if side in strips else 0.0
        for side in sides
    ]
    return float(min(parts))


def kind_of(grid: WallGrid, where: Rectangle) -> Kind:
    """Whether a hole is a door or a window, by where it ends below."""
    if where.bottom * CELL < _STEP:
        return "door"
    below = grid.solid[: where.bottom, where.columns]
    return "window" if where.bottom * CELL >= _SILL or below.mean() > 0.5 else "door"


def without_casing(grid: WallGrid, where: Rectangle) -> Rectangle:
    """A door without the boards around it, which are called door too but lie on the wall."""
    standing = grid.solid & (np.nan_to_num(grid.relief) > _CASING[1])
    most = round(_CASING[0] / CELL)
    columns = standing[where.rows, where.columns].mean(axis=0) > 0.5
    rows = standing[where.rows, where.columns].mean(axis=1) > 0.5
    return Rectangle(
        where.bottom,
        where.top - _depth(rows[::-1], most),
        where.left + _depth(columns, most),
        where.right - _depth(columns[::-1], most),
    )


def _depth(casing: Mask, most: int) -> int:
    """How far from its beginning a line of cells is casing, strays and all."""
    found = np.flatnonzero(casing[:most])
    return int(found[-1]) + 1 if len(found) else 0
