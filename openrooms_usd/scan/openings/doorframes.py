"""Closed doors without labels, by step edges in a wall's relief and colour.

A leaf that closes flush with its wall makes no hole. But its frame protrudes by a centimetre or
two, or the leaf is recessed by as much, along two vertical lines down to the floor and a horizontal
one at door height. Averages along such lines resolve steps far below the noise of a point. Where
the scan has colours, a leaf may also differ from its wall by these.
"""

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.openings.cellcounts import CELL_M
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallpicture import WallGrid

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
