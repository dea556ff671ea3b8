"""What may have been meant by a number or a text: centimetres, or a colour as screens have it."""

import re
from typing import Any, Final

_HEX: Final = re.compile(r"#?([0-9A-Fa-f]{6}|(?<=#)[0-9A-Fa-f]{3})")
_COLOURS: Final = ("color", "ground")
# What people measure things of rooms in, besides metres: how many go into one.
_PER_METRE: Final = {"cm": 100.0, "mm": 1000.0}
_LONG_M: Final = 10.0


def in_metres(length: float, most: float) -> str:
    """`` (255 cm? write 2.55)`` for a length that is too large, where it would fit in cm or mm."""
    for unit, count in _PER_METRE.items():
        if 0.0 < length / count <= min(most, _LONG_M):
            return f" ({length:g} {unit}? write {length / count:g})"
    return ""


def as_linear(path: tuple[str | int, ...], found: Any) -> str:
    """What to write for a colour in the numbers of screens, where the value can be one.

    Args:
        path: Of the value in the description.
        found: The value.
    """
    if isinstance(found, str) and (match := _HEX.fullmatch(found.strip())):
        digits = match[1] if len(match[1]) == 6 else "".join(digit * 2 for digit in match[1])
        codes = [int(digits[i : i + 2], 16) for i in (0, 2, 4)]
        return f" (colours are scene-linear, from 0 to 1: write {_linear(codes)})"
    if isinstance(found, int | float) and 2 <= found <= 255 and {*path} & {*_COLOURS}:
        return f" (colours are scene-linear, from 0 to 1: {found:g} of 255 is {_linear([found])})"
    return ""


def _linear(codes: list[int] | list[float]) -> str:
    # Reading descriptions imports nothing that only mistakes need.
    import numpy as np

    from openrooms_usd.colorimetry import linear_from_srgb

    values = [f"{value:.3g}" for value in linear_from_srgb(np.array(codes, float) / 255.0)]
    return f"[{', '.join(values)}]" if len(values) > 1 else values[0]
