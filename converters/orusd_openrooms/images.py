"""The 8-bit pictures, in the encodings that the loaders undo."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic
from openrooms_usd.arrays import Bytes
from openrooms_usd.imagefile import write_png

Pixels = NDArray[Any]

# Loaders raise stored base colours to this power; the exact sRGB curve would be off by up to 0.01.
GAMMA: Final = 2.2
# Of ``immask``: the sky, a lamp, anything else. Loaders cut at 0.49 and 0.51 of 255.
SKY, LAMP, OBJECT = 0, 127, 255


def write_picture(path: Path, pixels: Bytes) -> None:
    """Write a PNG of three channels, as every loader expects; grey is repeated.

    Args:
        path: The file.
        pixels: (height, width, 1 or 3).

    Raises:
        OutputError: The file cannot be written.
    """
    with atomic.replacing(path) as beside:
        write_png(beside, np.ascontiguousarray(np.broadcast_to(pixels, (*pixels.shape[:2], 3))))


def base_color(linear: Pixels) -> Bytes:
    """Scene-linear reflectance as the loaders' power curve."""
    return ratio(np.clip(linear, 0.0, 1.0) ** (1.0 / GAMMA))


def ratio(values: Pixels) -> Bytes:
    """What lies between 0 and 1, linear; what is no number becomes 0."""
    known = np.nan_to_num(values.astype(np.float64), nan=0.0)
    return np.rint(255.0 * np.clip(known, 0.0, 1.0)).astype(np.uint8)


def direction(vectors: Pixels) -> Bytes:
    """Unit vectors as 0.5 (v + 1); no vector stays 0."""
    there = (vectors != 0).any(axis=-1, keepdims=True)
    return np.where(there, ratio(0.5 * (vectors + 1.0)), 0).astype(np.uint8)


def light_mask(valid: Pixels, emits: Pixels) -> Bytes:
    """The mask of light sources.

    Args:
        valid: (height, width, 1) above 0 where there is a surface.
        emits: (height, width, 1) above 0 where that surface emits.

    Returns:
        (height, width, 1) `SKY`, `LAMP` or `OBJECT`.
    """
    return np.where(valid > 0, np.where(emits > 0, LAMP, OBJECT), SKY).astype(np.uint8)
