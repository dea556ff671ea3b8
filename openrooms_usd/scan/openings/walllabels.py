"""Evidence of openings in labels, robust to labels that bleed over borders and to wrong blobs."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy import ndimage

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.scan.openings.cellcounts import BLINDS, CELL_M, CURTAIN, usual_counts
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallholes import HIDDEN_WEIGHT, LABELS, Kind, hole_weights
from openrooms_usd.scan.openings.wallpicture import WallGrid

# Labels of a cell have full weight from this part of their usual number on.
_SURE_LABEL_SHARE: Final = 0.25
# Distance between folds of a curtain, metres.
_FOLD_DISTANCE_M: Final = 0.2
# Weight of a void against a label, and the distance within which a return must have the label, as
# the frame around a pane does, metres; else a void has none.
_LOOKED_THROUGH_WEIGHT: Final = 0.6
_FRAME_TO_PANE_M: Final = 0.6
_ON_THE_FACE_WEIGHT: Final = 0.6
# Largest width and least relief of casings, metres.
_CASING_WIDTH_AND_RELIEF_M: Final = (0.1, 0.005)
# Blobs of wrong labels are round: their bounding rectangle has fewer labels in its corners and more
# beyond the middle of its sides. Size of these patches, as a share of the sides, and the least
# difference of a rectangle.
_CORNER_SHARE: Final = 0.2
_SQUARE_SHARE: Final = 0.65
# Least recess of a window's pane from its wall, metres.
_MIN_PANE_DEPTH_M: Final = 0.012


def label_weights(grid: WallGrid, kind: Kind) -> Array:
    """(Z, X) weights by labels, and where there are none, by geometry."""
    votes, all_votes, curtain = (
        around(counts, grid.window)
        for counts in (
            grid.labels[LABELS[kind]],
            grid.labelled,
            grid.labels[CURTAIN] + grid.labels[BLINDS],
        )
    )
    others = all_votes - curtain
    geometry = hole_weights(grid)
    named = ndimage.distance_transform_edt(votes <= 0) * CELL_M < _FRAME_TO_PANE_M
    through = np.where(named, _LOOKED_THROUGH_WEIGHT * geometry, HIDDEN_WEIGHT)
    geometry = np.where(geometry > 0, through, geometry)
    # Voids between the folds of a curtain are no holes.
    hangs = ndimage.maximum_filter(curtain, round(_FOLD_DISTANCE_M / CELL_M)) > 0
    geometry = np.where(hangs, np.minimum(geometry, HIDDEN_WEIGHT), geometry)
    # Where few returns have a label, as outliers in a hole, geometry counts as well.
    enough = _SURE_LABEL_SHARE * usual_counts(grid.labelled, all_votes)
    weights = (2.0 * votes - others) / np.maximum(others, enough)
    # Labels on the wall's face count less: wrong ones lie there, openings mostly do not.
    weights = np.where(grid.solid & (weights > 0), _ON_THE_FACE_WEIGHT * weights, weights)
    return np.asarray(weights + geometry * (1.0 - np.minimum(others / enough, 1.0)))


def around(counts: Array, window: int) -> Array:
    """(Z, X) means over windows of so many cells."""
    smooth = ndimage.uniform_filter(counts, window, mode="nearest")
    return np.where(smooth < 1e-9, 0.0, smooth)


def is_round(grid: WallGrid, kind: Kind, where: Rectangle) -> bool:
    """Whether the returns with a label form a disc rather than a rectangle."""
    known = around(grid.labelled, grid.window)
    named = around(grid.labels[LABELS[kind]], grid.window) > 0.5 * known
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
    """The share of labelled cells in some rectangles that have the label."""
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
    """A door without its casing, which is labelled door, too; a door of nothing else stays."""
    standing = grid.solid & (np.nan_to_num(grid.relief) > _CASING_WIDTH_AND_RELIEF_M[1])
    most = round(_CASING_WIDTH_AND_RELIEF_M[0] / CELL_M)
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
    """Width of the casing at the beginning of a line of cells, gaps included."""
    found = np.flatnonzero(casing[:most])
    return int(found[-1]) + 1 if len(found) else 0
