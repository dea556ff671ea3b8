"""NumPy's files of unknown origin: what a header claims is weighed before memory is taken.

Only numbers are admitted, and texts where they are asked for: no objects, which would be pickles,
and no records.
"""

import math
import os
import tokenize
import warnings
from collections.abc import Collection
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.unpickling.archives import opened_archive

# Letters of numpy for numbers, and for texts of a fixed length.
NUMBERS: Final = "buif"
TEXTS: Final = "US"
# Version 3 differs only in the names of records, which are not admitted.
_HEADERS: Final = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
# What numpy raises for headers that are damaged: it takes them for Python.
_DAMAGE: Final = (
    *(ValueError, TypeError, LookupError, AttributeError, EOFError, SyntaxError),
    *(RecursionError, MemoryError, OverflowError, tokenize.TokenError),
)
# Packed numbers unpack to no more than this, or to so many times the file: honest ones are noisy.
_SMALL: Final = 256 << 20
_MOST_GAIN: Final = 64


def read_arrays(
    path: Path, names: Collection[str], kind: untrusted.Kind = "array", kinds: str = NUMBERS
) -> dict[str, NDArray[Any]]:
    """Those arrays of an ``.npz`` file that have one of some names, by their names.

    Args:
        path: The file.
        names: Of the arrays.
        kind: What the file should be.
        kinds: What the arrays may hold, by numpy's letters.

    Raises:
        InputError: It cannot be read, is damaged, or such an array holds anything else.
    """
    found = {}
    with opened_archive(path, kind) as archive:
        wanted = {f"{name}.npy": name for name in names}
        entries = [info for info in archive.infolist() if info.filename in wanted]
        claimed = sum(info.file_size for info in entries)
        if claimed > max(_SMALL, _MOST_GAIN * path.stat().st_size):
            raise _refused(path, f"its arrays claim {claimed / 2**30:.1f} GiB")
        for info in entries:
            with archive.open(info) as stream:
                found[wanted[info.filename]] = _array(
                    stream, info.file_size, f"{path}[{info.filename}]", kinds
                )
    return found


def read_array(path: Path, dimensions: int | None, kinds: str) -> NDArray[Any]:
    """The array of an ``.npy`` file, whole: nothing is missing, and nothing comes after it.

    Args:
        path: The file.
        dimensions: How many it must have; None: any.
        kinds: What it may hold, by numpy's letters: such as ``f`` or ``iu``.

    Raises:
        InputError: It cannot be read, is damaged, or is not such an array.
    """
    with untrusted.opened(path, "array", remedy="check the path, or make the file again") as stream:
        size = os.fstat(stream.fileno()).st_size
        admitted = kinds if set(kinds) & set(TEXTS) else NUMBERS
        found = _array(stream, size, path, admitted)
        if stream.read(1):
            raise _refused(path, f"there are more than its {found.nbytes:,} bytes of numbers")
    right = dimensions is None or found.ndim == dimensions
    if not right or found.dtype.kind not in kinds or not found.size:
        raise _refused(path, f"{found.ndim} dimensions of {found.dtype}, or nothing in it")
    return found


def _array(stream: IO[bytes], size: int, place: object, kinds: str) -> NDArray[Any]:
    """The array that a stream of that many bytes holds."""
    shape, fortran, dtype = _header(stream, place)
    if dtype.kind not in kinds or dtype.fields or dtype.subdtype or not dtype.itemsize:
        what = "numbers or words" if set(TEXTS) <= set(kinds) else "numbers"
        raise _refused(place, f"it holds no {what} but {str(dtype)[:60]}")
    if any(side < 0 for side in shape):
        raise _refused(place, f"its shape is {str(shape)[:60]}")
    count = math.prod(shape)
    if count * dtype.itemsize > size - stream.tell():
        claimed = f"{count * dtype.itemsize / 2**20:,.0f} MiB are announced"
        raise _refused(place, f"it ends too early: {claimed}, and {size / 2**20:,.0f} are there")
    values = np.empty(count, dtype)
    left = values.view(np.uint8).data
    while len(left) and (done := stream.readinto(left)):  # type: ignore[attr-defined]
        left = left[done:]
    if len(left):
        raise _refused(place, "it ends too early")
    try:
        return values.reshape(shape, order="F" if fortran else "C")
    except ValueError as error:  # more axes than numpy has
        raise _refused(place, str(error)) from error


def _header(stream: IO[bytes], place: object) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that Python 2 wrote it
            version = npy.read_magic(stream)
            if version not in _HEADERS:
                raise ValueError(f"its version is {version[0]}.{version[1]}")
            return _HEADERS[version](stream)
    except _DAMAGE as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise _refused(place, reason) from error


def _refused(place: object, reason: str) -> InputError:
    return InputError(f"not a readable array: {reason}", place=place, remedy="save the array again")
