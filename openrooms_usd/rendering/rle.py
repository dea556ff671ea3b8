"""Masks as run lengths, the way COCO stores them (Lin et al. 2014; maskApi of its own tools)."""

import numpy as np

from openrooms_usd.arrays import Mask

# A character carries five bits, a sixth says that more follow, and 48 makes all of them printable.
_BITS, _MORE, _FIRST = 5, 0x20, 48
_SIGN = 1 << (_BITS - 1)


def run_lengths(mask: Mask) -> list[int]:
    """The lengths of alternating runs of zeros and ones, column after column, zeros first.

    Args:
        mask: (height, width).
    """
    flat = mask.ravel(order="F")
    changes = np.flatnonzero(np.diff(flat)) + 1
    lengths: list[int] = np.diff([0, *changes.tolist(), flat.size]).tolist()
    return [0, *lengths] if flat.size and flat[0] else lengths


def compressed(counts: list[int]) -> str:
    """Run lengths as COCO's short text.

    From the third run on, the difference to the run before the last is stored; every number is cut
    into groups of five bits, the lowest first, as many as its sign needs.
    """
    ahead = counts[:3]
    return "".join(
        _number(value)
        for value in [*ahead, *(b - a for a, b in zip(counts[1:], counts[3:], strict=False))]
    )


def _number(value: int) -> str:
    text = ""
    while True:
        group, value = value & 0x1F, value >> _BITS
        done = value == (-1 if group & _SIGN else 0)
        text += chr(_FIRST + (group if done else group | _MORE))
        if done:
            return text


def tight_box(mask: Mask) -> tuple[int, int, int, int]:
    """Left, top, right and bottom edge of the pixels of a mask that is not empty.

    Args:
        mask: (height, width).

    Returns:
        Pixels from the upper left corner of the picture; right and bottom are exclusive.
    """
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1
