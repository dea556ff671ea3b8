"""Vectors as rows of arrays."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

UP: Final = (0.0, 0.0, 1.0)


def unit(vectors: Array, otherwise: ArrayLike | None = None) -> Array:
    """The vectors at length one.

    Args:
        vectors: (..., D).
        otherwise: (D,) what stands for a vector of length zero; without it that stays zero.
    """
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    found = np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0))
    return found if otherwise is None else np.where(lengths > 0.0, found, otherwise)
