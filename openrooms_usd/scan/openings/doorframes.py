"""Frames of doors in a wall's relief and colour: what is left of closed ones without labels.

A leaf that closes flush with its wall makes no hole. But a frame stands out by a centimetre or two
around it, or the leaf lies that much deeper than the wall, along two upright lines that reach the
floor and one across at the height of a door. Means over such long lines show steps far smaller
than the noise of a point. Where the scan has colours, a leaf may also differ from its wall by them.
"""

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallpicture import CELL, WallGrid

Array = NDArray[np.float64]
Step = Callable[[Array], Array]

# Where the uprights are looked at, and where the upper edge may be; metres.
_UPRIGHT_HEIGHTS_M: Final = (0.25, 1.8)
# Uprights go all the way down: in each of these parts they are this much of the whole.
_UPRIGHT_PARTS_M: Final = ((0.1, 0.7), (0.7, 1.3), (1.3, 1.8))
_MIN_PART_SHARE: Final = 0.15
_PARTS_UNSEEN: Final = 1
# A frame is as thick on all its sides: the least step is more than this part of the largest.
_MIN_STEP_RATIO: Final = 0.3
_TOP_HEIGHTS_M: Final = (1.85, 2.45)
_WIDTHS_M: Final = (0.6, 1.25)
# Width of what stands out, and of what it is compared with, cells.
_FRAME_CELLS: Final = 3
_BESIDE_CELLS: Final = 3
# Least steps, metres, in units of their usual size on this wall, and the sum of all three.
_USUAL_STEP_M: Final = 0.003
_MIN_STEP_RATIO_USUAL: Final = 2.5
_MIN_STEP_SUM: Final = 12.0
_MIN_USUAL_STEP_M: Final = 0.0008
# What a step counts for that a leaf hides from one side.
_HIDDEN_STEP_WEIGHT: Final = 0.5
# Doors are farther apart than the two sides of one's casing, metres.
_CASING_M: Final = 0.25
# This part of a line must have returned.
_MIN_RETURN_SHARE: Final = 0.3


def frames(grid: WallGrid) -> Iterator[tuple[Rectangle, float]]:
    """The doors that their frames betray: clear openings, and how clear they are from 0 to 1."""
    if grid.shape[0] <= round(_TOP_HEIGHTS_M[0] / CELL):
        return
    apart = round(_CASING_M / CELL)
    taken = np.zeros(grid.shape[1], dtype=np.bool_)
    # What stands out is a frame; what lies deeper may be a panel of the leaf as well; what has
    # another colour may be anything that is as large as a door.
    for step, picture in (
        (_proud, grid.relief), (_sunken, grid.relief), (_sunken, grid.tint), (_sunken, -grid.tint),
    ):  # fmt: skip
        for where, score in sorted(_pairs(picture, step), key=lambda pair: -pair[1]):
            if not taken[where.columns].any():
                taken[max(where.left - apart, 0) : where.right + apart] = True
                yield where, min(1.0, score / (3.0 * _MIN_STEP_SUM))


def _uprights(picture: Array, step: Step, turn: int) -> tuple[Array, Array]:
    """Steps at the boundaries between columns: in metres, and how clear they are.

    Those that end above the floor are not clear at all: they are of windows and pictures.
    """
    parts = []
    for low, high in (_UPRIGHT_HEIGHTS_M, *_UPRIGHT_PARTS_M):
        profile = _profile(picture[round(low / CELL) : round(high / CELL)], axis=0)
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
    """How far a band before each boundary stands out of what is farther before, and behind."""
    band = _window(values, -_FRAME_CELLS, 0)
    outer = band - _window(values, -_FRAME_CELLS - _BESIDE_CELLS, -_FRAME_CELLS)
    inner = band - _window(values, 1, 1 + _BESIDE_CELLS)
    # On the side of its hinges a leaf that is ajar comes out farther than the frame.
    ajar = inner < -_USUAL_STEP_M
    framed = np.where(np.isfinite(inner), np.minimum(outer, inner), outer)
    return np.where(ajar, _HIDDEN_STEP_WEIGHT * outer, framed)


def _sunken(values: Array) -> Array:
    """How much deeper what lies behind each boundary is than what lies before."""
    return _window(values, -_BESIDE_CELLS, 0) - _window(values, 1, 1 + _BESIDE_CELLS)


def _pairs(picture: Array, step: Step) -> Iterator[tuple[Rectangle, float]]:
    (left_size, left), (right_size, right) = (_uprights(picture, step, turn) for turn in (1, -1))
    least, most = (round(width / CELL) for width in _WIDTHS_M)
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
    """The row of the upper edge, how clear its step is, and how large, metres."""
    low, high = (round(height / CELL) for height in _TOP_HEIGHTS_M)
    rows = _profile(picture[:, left + 2 : right - 2], axis=1)
    steps = step(rows[::-1])[::-1]
    clear = _relative(steps)[low : min(high, len(picture) - _FRAME_CELLS)]
    if not clear.any():
        return 0, 0.0, 0.0
    top = low + int(clear.argmax())
    return top, float(clear.max()), float(steps[top])


def _relative(steps: Array) -> Array:
    """Steps in units of their usual size, none where they are too small or not known."""
    known = steps[np.isfinite(steps)]
    if len(known) < 4 * _FRAME_CELLS:
        return np.zeros(len(steps))
    usual = max(1.4826 * float(np.median(np.abs(known - np.median(known)))), _MIN_USUAL_STEP_M)
    clear = np.isfinite(steps) & (steps > _USUAL_STEP_M)
    return np.where(
        clear, np.minimum(np.where(clear, steps, 0.0) / usual, 3.0 * _MIN_STEP_SUM), 0.0
    )
