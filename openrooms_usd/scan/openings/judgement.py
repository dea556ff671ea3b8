"""How likely a proposal is an opening: weighed evidence, as probabilities that hold.

Each kind of proposal has a table of evidence, and a logistic sum of it is the probability. The
weights are a ridge fit to proposals in simulated and real scans with known openings. None is
negative, so that evidence never speaks for the opposite; holes, views behind and free ways have a
least weight by reason. A scan that is left out of the fit is judged nearly as well as the others.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import ndimage

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.scan.openings import wallholes
from openrooms_usd.scan.openings.cellcounts import BLINDS, CELL_M, CURTAIN, usual_counts
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallpicture import WallGrid

# Part of a doorway through which something is seen far behind where it is surely open.
_OPEN_VIEW_SHARE: Final = 0.7
# Higher and wider doors are unusual, and by so much the heads of usual ones differ, metres.
_TALL_DOOR_M: Final = 2.35
_WIDE_DOOR_M: Final = 1.8
_USUAL_HEAD_M, _HEAD_RANGE_M, _MOST_RANGES = 2.05, 0.2, 1.5
# Windows smaller than the first area, with sills above the second range of heights, or as near to
# the ceiling as the third, are less likely; square metres and metres.
_USUAL_WINDOW_M2: Final = 0.8
_HIGH_SILLS_M: Final = (1.6, 2.4)
_MOST_HIGH: Final = 2.0
_UNDER_CEILING_M: Final = 0.15
_SMALL_WINDOW_M: Final = 0.4
# A hole of which so much is one and is framed by wall is a clean one.
_CLEAN_SHARES: Final = (0.65, 0.9)

Measure = Callable[[wallholes.Proposal], float]


@dataclass(frozen=True)
class Evidence:
    """Evidence from 0 to about 1, and what it adds to the log odds."""

    measure: Measure
    weight: float


def _passed(p: wallholes.Proposal) -> float:
    return max(p.threshold, min(1.0, p.beyond / _OPEN_VIEW_SHARE))


def _vast(p: wallholes.Proposal) -> float:
    return -float(p.width > _WIDE_DOOR_M or p.height > _TALL_DOOR_M)


def _unusual_head(p: wallholes.Proposal) -> float:
    return min(_MOST_RANGES, abs(p.height - _USUAL_HEAD_M) / _HEAD_RANGE_M)


def _high(p: wallholes.Proposal) -> float:
    low, high = _HIGH_SILLS_M
    return float(np.clip((p.sill - low) / (high - low), 0.0, _MOST_HIGH))


def _clean(p: wallholes.Proposal) -> float:
    low, high = _CLEAN_SHARES
    return float(np.clip((p.framed * p.hole - low) / (high - low), 0.0, 1.0))


DOORWAY: Final[Mapping[str, Evidence]] = {
    "a hole": Evidence(lambda p: p.hole, 3.00),
    "wall on every side": Evidence(lambda p: p.framed, 2.38),
    "wall around": Evidence(lambda p: p.walled, 0.80),
    "floor or a view behind": Evidence(_passed, 1.00),
    "furniture around": Evidence(lambda p: -p.clutter, 1.67),
    "furniture before it": Evidence(lambda p: -p.blocked * (1.0 - _passed(p)), 2.00),
    "larger than a double door": Evidence(_vast, 1.95),
}
CLOSED_DOOR: Final[Mapping[str, Evidence]] = {
    "a frame": Evidence(lambda p: p.leaf, 1.02),
    "wall on every side": Evidence(lambda p: p.framed, 1.75),
    "wall around": Evidence(lambda p: p.walled, 0.73),
    "open, with a view behind": Evidence(lambda p: p.hole * _passed(p), 1.54),
    "furniture around": Evidence(lambda p: -p.clutter, 0.87),
    "furniture before a closed leaf": Evidence(lambda p: -p.blocked * p.solid, 3.95),
    "unusual height": Evidence(lambda p: -_unusual_head(p), 1.46),
}
WINDOW: Final[Mapping[str, Evidence]] = {
    "a hole": Evidence(lambda p: p.hole, 3.00),
    "wall on every side": Evidence(lambda p: p.framed, 2.29),
    "wall around": Evidence(lambda p: p.walled, 2.21),
    "clean": Evidence(_clean, 1.93),
    "furniture around": Evidence(lambda p: -p.clutter, 1.53),
    "large": Evidence(lambda p: min(1.0, p.width * p.height / _USUAL_WINDOW_M2), 3.48),
    "high above the floor": Evidence(lambda p: -_high(p), 1.58),
    "under the ceiling": Evidence(lambda p: -float(p.headroom < _UNDER_CEILING_M), 1.42),
    "seen through": Evidence(lambda p: p.hole - p.recess, 0.51),
    "small": Evidence(lambda p: -float(min(p.width, p.height) < _SMALL_WINDOW_M), 2.06),
}
# Log odds without evidence.
_PRIORS: Final = {"doorway": -3.14, "closed door": -0.71, "window": -8.46}
_TABLES: Final = {"doorway": DOORWAY, "closed door": CLOSED_DOOR, "window": WINDOW}


def likelihood(proposal: wallholes.Proposal) -> float:
    """The probability that a proposal is an opening, by what the wall shows without labels."""
    sort = "window" if proposal.kind == "window" else "closed door" if proposal.leaf else "doorway"
    odds = _PRIORS[sort] + sum(e.weight * e.measure(proposal) for e in _TABLES[sort].values())
    return float(1.0 / (1.0 + np.exp(-odds)))


# Evidence of openings in labels, robust to labels that bleed over borders and to wrong blobs.

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


def label_weights(grid: WallGrid, kind: wallholes.Kind) -> Array:
    """(Z, X) weights by labels, and where there are none, by geometry."""
    votes, all_votes, curtain = (
        around(counts, grid.window)
        for counts in (
            grid.labels[wallholes.LABELS[kind]],
            grid.labelled,
            grid.labels[CURTAIN] + grid.labels[BLINDS],
        )
    )
    others = all_votes - curtain
    geometry = wallholes.hole_weights(grid)
    named = ndimage.distance_transform_edt(votes <= 0) * CELL_M < _FRAME_TO_PANE_M
    through = np.where(named, _LOOKED_THROUGH_WEIGHT * geometry, wallholes.HIDDEN_WEIGHT)
    geometry = np.where(geometry > 0, through, geometry)
    # Voids between the folds of a curtain are not holes.
    hangs = ndimage.maximum_filter(curtain, round(_FOLD_DISTANCE_M / CELL_M)) > 0
    geometry = np.where(hangs, np.minimum(geometry, wallholes.HIDDEN_WEIGHT), geometry)
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


def is_round(grid: WallGrid, kind: wallholes.Kind, where: Rectangle) -> bool:
    """Whether the returns with a label form a disc rather than a rectangle."""
    known = around(grid.labelled, grid.window)
    named = around(grid.labels[wallholes.LABELS[kind]], grid.window) > 0.5 * known
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


# Closed doors without labels, by step edges in a wall's relief and colour.
#
# A leaf that closes flush with its wall makes no hole. But its frame protrudes by a centimetre or
# two, or the leaf is recessed by as much, along two vertical lines down to the floor and a
# horizontal one at door height. Averages along such lines resolve steps far below the noise of a
# point. Where the scan has colours, a leaf may also differ from its wall by these.

Step = Callable[[Array], Array]

# Range of heights in which vertical edges are measured, metres.
_UPRIGHT_HEIGHTS_M: Final = (0.25, 1.8)
# Vertical edges are continuous: in each of these sections the step is at least this share of the
# whole, but for so many sections without returns.
_UPRIGHT_PARTS_M: Final = ((0.1, 0.7), (0.7, 1.3), (1.3, 1.8))
_MIN_PART_SHARE: Final = 0.15
_PARTS_UNSEEN: Final = 1
# The steps of all sides are similar: least ratio of the smallest to the largest.
_MIN_STEP_RATIO: Final = 0.3
_TOP_HEIGHTS_M: Final = (1.85, 2.45)
_WIDTHS_M: Final = (0.6, 1.4)
# Widths of the two windows that a step compares, cells.
_FRAME_CELLS: Final = 3
_BESIDE_CELLS: Final = 3
# Steps are compared with their median on the wall: its default, the least multiple, the least sum
# of all three, and its least value.
_USUAL_STEP_M: Final = 0.003
_MIN_STEP_RATIO_USUAL: Final = 2.5
_MIN_STEP_SUM: Final = 12.0
_MIN_USUAL_STEP_M: Final = 0.0008
# Weight of a step that a leaf hides from one side.
_HIDDEN_STEP_WEIGHT: Final = 0.5
# Doors nearer to each other than this are the inner and outer edge of one casing, metres.
_CASING_M: Final = 0.25
# Least part of a line with returns.
_MIN_RETURN_SHARE: Final = 0.3


def frames(grid: WallGrid) -> Iterator[tuple[Rectangle, float]]:
    """Doors with visible frames: their clear openings, and scores from 0 to 1."""
    if grid.shape[0] <= round(_TOP_HEIGHTS_M[0] / CELL_M):
        return
    apart = round(_CASING_M / CELL_M)
    taken = np.zeros(grid.shape[1], dtype=np.bool_)
    # In order of reliability: protrusions are frames, recesses may be panels of the leaf, and
    # another colour may be anything of a door's size.
    for step, picture in (
        (_proud, grid.relief),
        (_sunken, grid.relief),
        (_sunken, grid.tint),
        (_sunken, -grid.tint),
    ):
        for where, score in sorted(_pairs(picture, step), key=lambda pair: -pair[1]):
            if not taken[where.columns].any():
                taken[max(where.left - apart, 0) : where.right + apart] = True
                yield where, min(1.0, score / (3.0 * _MIN_STEP_SUM))


def _uprights(picture: Array, step: Step, turn: int) -> tuple[Array, Array]:
    """Steps at the boundaries between columns, metres, and their significance.

    That is 0 for those that end above the floor, as those of windows and pictures do.
    """
    parts = []
    for low, high in (_UPRIGHT_HEIGHTS_M, *_UPRIGHT_PARTS_M):
        profile = _profile(picture[round(low / CELL_M) : round(high / CELL_M)], axis=0)
        parts.append(step(profile[::turn])[::turn])
    whole = parts[0]
    unseen = np.sum([np.isnan(part) for part in parts[1:]], axis=0) > _PARTS_UNSEEN
    ends = np.any([part < _MIN_PART_SHARE * whole for part in parts[1:]], axis=0)
    return whole, np.where(unseen | ends, 0.0, _relative(whole))


def _profile(relief: Array, axis: int) -> Array:
    """Medians of the relief along lines; NaN where too little returned."""
    seen = np.isfinite(relief).mean(axis=axis) >= _MIN_RETURN_SHARE
    full = np.where(seen if axis == 0 else seen[:, None], relief, 0.0)
    return np.where(seen, np.nanmedian(full, axis=axis), np.nan)


def _window(values: Array, first: int, last: int) -> Array:
    """(N + 1,) means of values from i + first to i + last, for every boundary i between cells."""
    pad = _FRAME_CELLS + _BESIDE_CELLS + 1
    padded = np.pad(values, (pad, pad + 1), constant_values=np.nan)
    shifted = [padded[pad + k : pad + k + len(values) + 1] for k in range(first, last)]
    known = np.isfinite(shifted)
    total = np.where(known, shifted, 0.0).sum(axis=0)
    return np.where(known.sum(axis=0) >= 2, total / np.maximum(known.sum(axis=0), 1), np.nan)


def _proud(values: Array) -> Array:
    """The protrusion of a band before each boundary over the windows on both its sides."""
    band = _window(values, -_FRAME_CELLS, 0)
    outer = band - _window(values, -_FRAME_CELLS - _BESIDE_CELLS, -_FRAME_CELLS)
    inner = band - _window(values, 1, 1 + _BESIDE_CELLS)
    # A leaf that is ajar protrudes over its frame at the hinges.
    ajar = inner < -_USUAL_STEP_M
    framed = np.where(np.isfinite(inner), np.minimum(outer, inner), outer)
    return np.where(ajar, _HIDDEN_STEP_WEIGHT * outer, framed)


def _sunken(values: Array) -> Array:
    """The recess of the window behind each boundary relative to that before it."""
    return _window(values, -_BESIDE_CELLS, 0) - _window(values, 1, 1 + _BESIDE_CELLS)


def _pairs(picture: Array, step: Step) -> Iterator[tuple[Rectangle, float]]:
    (left_size, left), (right_size, right) = (_uprights(picture, step, turn) for turn in (1, -1))
    least, most = (round(width / CELL_M) for width in _WIDTHS_M)
    for a in np.flatnonzero(left > _MIN_STEP_RATIO_USUAL):
        for b in (
            np.flatnonzero(right[a + least : a + most + 1] > _MIN_STEP_RATIO_USUAL) + a + least
        ):
            top, score, size = _head(picture, int(a), int(b), step)
            total = score + float(left[a] + right[b])
            sizes = (float(left_size[a]), float(right_size[b]), size)
            if (
                score > _MIN_STEP_RATIO_USUAL
                and total > _MIN_STEP_SUM
                and min(sizes) > _MIN_STEP_RATIO * max(sizes)
            ):
                yield Rectangle(0, top, int(a), int(b)), total


def _head(picture: Array, left: int, right: int, step: Step) -> tuple[int, float, float]:
    """The row of the upper edge, the significance of its step, and its size, metres."""
    low, high = (round(height / CELL_M) for height in _TOP_HEIGHTS_M)
    rows = _profile(picture[:, left + 2 : right - 2], axis=1)
    steps = step(rows[::-1])[::-1]
    clear = _relative(steps)[low : min(high, len(picture) - _FRAME_CELLS)]
    if not clear.any():
        return 0, 0.0, 0.0
    top = low + int(clear.argmax())
    return top, float(clear.max()), float(steps[top])


def _relative(steps: Array) -> Array:
    """Steps in units of their median; 0 where they are too small or not known."""
    known = steps[np.isfinite(steps)]
    if len(known) < 4 * _FRAME_CELLS:
        return np.zeros(len(steps))
    usual = max(1.4826 * float(np.median(np.abs(known - np.median(known)))), _MIN_USUAL_STEP_M)
    clear = np.isfinite(steps) & (steps > _USUAL_STEP_M)
    return np.where(
        clear, np.minimum(np.where(clear, steps, 0.0) / usual, 3.0 * _MIN_STEP_SUM), 0.0
    )
