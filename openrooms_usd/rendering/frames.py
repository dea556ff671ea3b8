"""Frames of a stage that moves: which time codes are rendered, and the folder of each."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from openrooms_usd.errors import InputError

_NUMBER: Final = r"[+-]?\d{1,12}(?:\.\d{1,6})?"
_RANGE: Final = re.compile(rf"({_NUMBER}):({_NUMBER})(?::({_NUMBER}))?")
_MOST_FRAMES: Final = 100_000
# Of a step: what rounding may cut off the last frame.
_ROUNDING: Final = 1e-6
_MOST_DECIMALS: Final = 6


def frames_of(text: str) -> tuple[float, ...]:
    """The time codes of ``A:B`` or ``A:B:STEP``, with both ends.

    Raises:
        InputError: It is not such a range, or has no end.
    """
    found = _RANGE.fullmatch(text.strip())
    if found is None:
        raise InputError(
            f"{text!r} is not a range of frames",
            place="--time-codes",
            remedy="give A:B or A:B:STEP, such as 1:48 or 0:10:0.5",
        )
    begin, end, step = (float(number or 1.0) for number in found.groups())
    if end < begin or step <= 0.0:
        raise InputError(
            f"{text} has no frames",
            place="--time-codes",
            remedy="give A:B:STEP with A <= B, STEP > 0",
        )
    count = math.floor((end - begin) / step + _ROUNDING) + 1
    if count > _MOST_FRAMES:
        raise InputError(f"{text} are more than {_MOST_FRAMES:,} frames", place="--time-codes")
    return tuple(round(begin + step * number, _MOST_DECIMALS) for number in range(count))


def frame_folders(out: Path, time_codes: Sequence[float]) -> dict[Path, float]:
    """Time code by the folder of its render: ``frame_0012``, with decimals where any has some.

    Args:
        out: Where the folders are.
        time_codes: As `frames_of` gives them.
    """
    texts = [f"{code:.{_MOST_DECIMALS}f}".partition(".")[2].rstrip("0") for code in time_codes]
    decimals = max(map(len, texts), default=0)
    width = 5 + decimals if decimals else 4
    return {out / f"frame_{code:0{width}.{decimals}f}": code for code in time_codes}
