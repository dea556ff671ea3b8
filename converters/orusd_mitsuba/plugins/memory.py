"""Memory that Dr.Jit reads as it is: where it begins must not change what is compiled."""

from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

# What the widest vectors of processors need; packets of four numbers need less.
_ALIGNMENT_BYTES: Final = 64

_Number = TypeVar("_Number", bound=np.generic)


def aligned(values: NDArray[_Number]) -> NDArray[_Number]:
    """The values in a row, in memory that begins at a multiple of 64 bytes.

    Dr.Jit takes numpy's memory without a copy, and gathers packets of numbers at once only where it
    is aligned. By chance it is or is not, so that equal scenes would get different kernels, and one
    process could not use what another has compiled.
    """
    size = values.nbytes
    room = np.empty(size + _ALIGNMENT_BYTES, dtype=np.uint8)
    start = -room.ctypes.data % _ALIGNMENT_BYTES
    found = room[start : start + size].view(values.dtype)
    found[:] = values.ravel()
    return found
