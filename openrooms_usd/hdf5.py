"""Arrays of numbers in untrusted HDF5 files."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.untrusted import checked

Sound = Callable[[tuple[int, ...], str], bool]
"""Whether an array of a shape and a kind (as of numpy's dtypes) is what is looked for."""

_MOST_NUMBERS: Final = 2**28


def read_array(path: Path, name: str, extra: str, sound: Sound) -> NDArray[Any]:
    """Read an array; nothing of other files: no links to them, and no numbers that lie there.

    Args:
        path: The file.
        name: Of the data set.
        extra: Which extra brings h5py.
        sound: Asked before memory is taken for it.

    Raises:
        InputError: It is missing, damaged, or holds no such data set.
        MissingPackageError: h5py is not installed.
    """
    try:
        import h5py
    except ImportError as error:
        remedy = f"pip install 'openrooms-usd[{extra}]'"
        raise MissingPackageError("HDF5 needs the package 'h5py'", remedy=remedy) from error
    checked(path, "array")
    try:
        with h5py.File(path, "r") as file:
            own = isinstance(file.get(name, getlink=True), h5py.HardLink)
            data = file[name] if own else None
            if data is None or data.external or data.is_virtual:
                raise InputError(f"its data set {name!r} is not in this file", place=path)
            shape, kind = data.shape or (), data.dtype.kind
            small = 0 < math.prod(shape) <= _MOST_NUMBERS
            if data.shape is None or not small or not sound(shape, kind):
                raise InputError(f"not what is expected: an array of {data.shape}", place=path)
            return np.asarray(data[()])
    # What the library makes of damage, and a group in the place of the data set.
    except (OSError, KeyError, TypeError, ValueError, AttributeError, RuntimeError) as error:
        raise InputError(f"no data set {name!r}: {error}", place=path) from error
