"""Arrays in ``.npy`` files: the header is checked before any memory is taken for numbers."""

import math
import warnings
from pathlib import Path
from tokenize import TokenError
from typing import Any, Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.untrusted import opened

_HEADERS: Final = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
# What numpy raises for headers, which it reads as Python.
_BAD_HEADER: Final = (
    ValueError, TypeError, SyntaxError, TokenError, EOFError, OverflowError, RecursionError,
    MemoryError,
)  # fmt: skip


def read_npy(path: Path, dimensions: int, kinds: str) -> NDArray[Any]:
    """An array of numbers.

    Args:
        path: The file.
        dimensions: How many it must have.
        kinds: What its numbers may be, by numpy's letters: such as ``f`` or ``iu``.

    Raises:
        InputError: It is missing, damaged, holds objects, or is no such array.
    """
    with opened(path, "array", remedy="make the file again") as stream:
        try:
            # It warns of what another reader would not understand; we refuse what is no array.
            with warnings.catch_warnings(action="ignore"):
                shape, by_columns, kind = _HEADERS[npy.read_magic(stream)](stream)
        except (KeyError, *_BAD_HEADER) as error:
            raise InputError(
                "not a readable array: damaged header", place=path, remedy="make the file again"
            ) from error
        wanted = math.prod(shape) * kind.itemsize
        data = stream.read()
    if len(shape) != dimensions or kind.kind not in kinds or min(shape, default=1) < 1:
        raise InputError(
            f"not a readable array: {len(shape)} dimensions of {kind}, or nothing in it",
            place=path, remedy="make the file again",
        )  # fmt: skip
    if len(data) != wanted:
        raise InputError(
            f"not a readable array: {len(data):,} bytes of numbers, not {wanted:,}",
            place=path, remedy="make the file again",
        )  # fmt: skip
    return np.frombuffer(data, kind).reshape(shape, order="F" if by_columns else "C")
