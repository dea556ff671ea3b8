"""What labels say of openings in a wall, and how labels go wrong: over borders and in blobs."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallholes import (
    BLINDS,
    CURTAIN,
    HIDDEN_WEIGHT,
    LABELS,
    Kind,
    hole_weights,
)
from openrooms_usd.scan.openings.wallpicture import CELL, WallGrid, usual_counts

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Cells with this part of the usual number of labels are sure of them.
_SURE_LABEL_SHARE: Final = 0.25
# So far apart are folds of a curtain, metres.
_FOLD_DISTANCE_M: Final = 0.2
# Looking through says less than a label, as a door may be seen through a window's place; and
# nothing where no return that has the name is as near as a frame is to the middle of its pane.
_LOOKED_THROUGH_WEIGHT: Final = 0.6
_FRAME_TO_PANE_SHARE: Final = 0.6
_ON_THE_FACE: Final = 0.6
# Boards around doors are up to so wide, and stand out at least so far, metres.
_CASING_WIDTH_AND_RELIEF_M: Final = (0.1, 0.005)
# Blobs of wrong labels are round: less of a square's corners is in its disc than in a rectangle,
# and beyond the middle of its sides there is more. Both are patches of this part of the sides.
_CORNER_SHARE: Final = 0.2
_SQUARE_SHARE: Final = 0.65
# Labelled windows lie deeper than their wall by so much, or nothing says that they do, metres.
_MIN_PANE_DEPTH_M: Final = 0.012


def label_weights(grid: WallGrid, kind: Kind) -> Array:
    """(Z, X) what labels say, and where there are none, geometry."""
    votes, all_votes = (around(counts) for counts in (grid.labels[LABELS[kind]], grid.labelled))
    curtain = around(grid.labels[CURTAIN] + grid.labels[BLINDS])
    others = all_votes - curtain
    geometry = hole_weights(grid)
    named = ndimage.distance_transform_edt(votes <= 0) * CELL < _FRAME_TO_PANE_SHARE
    through = np.where(named, _LOOKED_THROUGH_WEIGHT * geometry, HIDDEN_WEIGHT)
    geometry = np.where(geometry > 0, through, geometry)
    # Between the folds that returned, others did not.
    hangs = ndimage.maximum_filter(curtain, round(_FOLD_DISTANCE_M / CELL)) > 0
    geometry = np.where(hangs, np.minimum(geometry, HIDDEN_WEIGHT), geometry)
    # Where few returns have a label, as strays in a hole, geometry is asked as well.
    enough = _SURE_LABEL_SHARE * usual_counts(grid.labelled, all_votes)
    said = (2.0 * votes - others) / np.maximum(others, enough)
    # Wrong labels lie on the wall's face, and openings mostly do not.
    said = np.where(grid.solid & (said > 0), _ON_THE_FACE * said, said)
    return np.asarray(said + geometry * (1.0 - np.minimum(others / enough, 1.0)))


def around(counts: Array) -> Array:
    """(Z, X) means over a cell and its neighbours."""
    smooth = ndimage.uniform_filter(counts, 3, mode="nearest")
    return np.where(smooth < 1e-9, 0.0, smooth)


def is_round(grid: WallGrid, kind: Kind, where: Rectangle) -> bool:
    """Whether returns of a name bulge out of a rectangle's sides and leave out its corners."""
    known = around(grid.labelled)
    named = around(grid.labels[LABELS[kind]]) > 0.5 * known
    high, wide = (
        max(1, round(_CORNER_SHARE * size)) for size in named[where.rows, where.columns].shape
    )
    w = where
    corners = [
        Rectangle(bottom, bottom + high, left, left + wide)
        for bottom in (w.bottom, w.top - high)
        for left in (w.left, w.right - wide)
    ]
    row, column = (w.bottom + w.top - high) // 2, (w.left + w.right - wide) // 2
    bulges = [
        *(Rectangle(row, row + high, left, left + wide) for left in (w.left - wide, w.right)),
        *(Rectangle(low, low + high, column, column + wide) for low in (w.bottom - high, w.top)),
    ]
    inside, outside = (_share(named, known > 0, places) for places in (corners, bulges))
    return inside - outside < _SQUARE_SHARE


def _share(named: Mask, known: Mask, places: Sequence[Rectangle]) -> float:
    """The part of what is known in some places that has a name."""
    of_all = 0
    with_name = 0
    for p in places:
        cells = slice(max(p.bottom, 0), p.top), slice(max(p.left, 0), p.right)
        of_all += int(known[cells].sum())
        with_name += int((named & known)[cells].sum())
    return with_name / max(of_all, 1)


def lies_deeper(grid: WallGrid, where: Rectangle) -> bool:
    """Whether a wall's face is deeper within a rectangle than beside it."""
    inside = grid.relief[where.rows, where.columns]
    side = max(4, (where.right - where.left) // 2)
    left = grid.relief[where.rows, max(where.left - side, 0) : where.left]
    right = grid.relief[where.rows, where.right : where.right + side]
    beside = np.concatenate([left, right], axis=1)
    if np.isfinite(inside).sum() < 20 or np.isfinite(beside).sum() < 20:
        return False
    return bool(np.nanmedian(beside) - np.nanmedian(inside) > _MIN_PANE_DEPTH_M)


def without_casing(grid: WallGrid, where: Rectangle) -> Rectangle:
    """A door without the boards around it, which are called door too but lie on the wall.

    What is nothing but boards stays as it is.
    """
    standing = grid.solid & (np.nan_to_num(grid.relief) > _CASING_WIDTH_AND_RELIEF_M[1])
    most = round(_CASING_WIDTH_AND_RELIEF_M[0] / CELL)
    columns = standing[where.rows, where.columns].mean(axis=0) > 0.5
    rows = standing[where.rows, where.columns].mean(axis=1) > 0.5
    inner = Rectangle(
        where.bottom,
        where.top - _depth(rows[::-1], most),
        where.left + _depth(columns, most),
        where.right - _depth(columns[::-1], most),
    )
    return inner if inner.left < inner.right and inner.bottom < inner.top else where


def _depth(casing: Mask, most: int) -> int:
    """How far from its beginning a line of cells is casing, strays and all."""
    found = np.flatnonzero(casing[:most])
    return int(found[-1]) + 1 if len(found) else 0
