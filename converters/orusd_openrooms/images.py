"""The 8-bit pictures, in the encodings that the loaders undo."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic
from openrooms_usd.arrays import Bytes, Floats
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
    """What lies between 0 and 1, linear; NaN becomes 0."""
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


# Radiance's RGBE pictures (.hdr, .rgbe): shared exponents, rounded rather than cut off.
#
# The format is Ward's ("Real Pixels", Graphics Gems II, 1991): three mantissas of 8 bits and one
# exponent e with value = mantissa 2^(e - 136).

HEADER: Final = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n"
# The largest error of a component, as a part of the pixel's largest component: half a step of a
# mantissa that is at least 128.
ERROR: Final = 0.5 / 128
# Readers take rows of other widths as written without packets.
_WIDTHS: Final = (8, 0x7FFF)
_EXPONENT_BIAS: Final = 136
_LARGEST: Final = np.float32(1e38)
_PACKET_BYTES: Final = 128  # bytes that one packet may hold as they are


def encode(pixels: Floats) -> Bytes:
    """Pixels as mantissas and exponents.

    Rounding makes the mean of many pixels right, where cutting off loses half a step of each.

    Args:
        pixels: (..., 3), not negative; what is negative or no number becomes 0.

    Returns:
        (..., 4) bytes.
    """
    # Of a number and no number these take the number.
    values = np.fmin(np.fmax(pixels, np.float32(0.0)), _LARGEST)
    largest = np.maximum(np.maximum(values[..., 0], values[..., 1]), values[..., 2])
    fraction, exponent = np.frexp(largest)
    # Where rounding carries the largest mantissa to 256, the next exponent holds it.
    exponent += fraction >= 255.5 / 256
    # The least exponent is 1: 0 marks black.
    seen = (largest > 0) & (exponent + _EXPONENT_BIAS - 8 >= 1)
    code = np.empty((*largest.shape, 4), np.uint8)
    code[..., :3] = np.rint(np.ldexp(values, (8 - exponent)[..., None])) * seen[..., None]
    code[..., 3] = (exponent + _EXPONENT_BIAS - 8) * seen
    return code


def write_rgbe(path: Path, pixels: Floats) -> None:
    """Write a picture; the same bytes for the same pixels.

    Args:
        path: The file.
        pixels: (height, width, 3), red first, top row first.

    Raises:
        OutputError: The file cannot be written.
    """
    height, width = pixels.shape[:2]
    code = encode(pixels)
    rows = _packed(code) if _WIDTHS[0] <= width <= _WIDTHS[1] else code
    atomic.write_bytes(path, HEADER % (height, width) + rows.tobytes())


def _packed(code: Bytes) -> Bytes:
    """Rows in packets that hold their bytes as they are: (height, bytes of a row).

    Runs would save space in flat pictures alone; light is noisy.
    """
    height, width = code.shape[:2]
    planes = code.transpose(0, 2, 1)
    parts = [np.broadcast_to(np.array([2, 2, width >> 8, width & 255], np.uint8), (height, 4))]
    for plane in range(4):
        for start in range(0, width, _PACKET_BYTES):
            piece = planes[:, plane, start : start + _PACKET_BYTES]
            parts += [np.full((height, 1), piece.shape[1], np.uint8), piece]
    return np.concatenate(parts, axis=1)
