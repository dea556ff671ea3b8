"""The ``.dat`` files of numbers: two int32 for the size, then the pixels, all little endian."""

import struct
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic


def write_binary(path: Path, pixels: NDArray[Any], kind: Literal["<f4", "<i4"]) -> None:
    """Write pixels row by row, the top row first.

    Args:
        path: The file.
        pixels: (height, width) or (height, width, components).
        kind: The type of a number.

    Raises:
        OutputError: The file cannot be written.
    """
    size = struct.pack("<ii", *pixels.shape[:2])
    atomic.write_bytes(path, size + np.ascontiguousarray(pixels, kind).tobytes())
