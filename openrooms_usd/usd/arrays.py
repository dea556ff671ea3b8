"""Values of attributes as arrays; a value of another type than the schema's counts as missing."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Tf, Usd, UsdGeom

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.usd.files.diagnostics import NO_TYPE
from openrooms_usd.usd.places.frames import TIME


def array_of(value: Any, dtype: type[np.generic], width: int | None = None) -> NDArray[Any]:
    """(N,) or (N, width); without rows where there is no value, or one that is not so wide.

    Args:
        value: What USD gives.
        dtype: Of the array.
        width: Numbers in each row; None for rows that are single numbers.

    Raises:
        TypeError: It is of a type that USD does not know: the file is damaged
            (`openrooms_usd.usd.files.diagnostics.reading`).
    """
    empty = np.zeros((0,) if width is None else (0, width), dtype)
    if value is None:
        return empty
    try:
        found = np.asarray(value).astype(dtype)
    except (TypeError, ValueError) as error:
        if NO_TYPE in str(error):
            raise
        return empty
    return found if found.ndim == empty.ndim and found.shape[1:] == empty.shape[1:] else empty


def in_rows(values: NDArray[Any]) -> NDArray[Any]:
    """(N, width) values, of which there may be none; each single number is a row of its own."""
    return values[:, None] if values.ndim == 1 else values


def flattened(primvar: UsdGeom.Primvar) -> Any:
    """A primvar's values in the order of its indices; None where these make no sense."""
    try:
        return primvar.ComputeFlattened(TIME)
    except Tf.ErrorException:
        return None


def number_of(value: Any) -> float | None:
    """A number, which may be infinite or none; None where there is no value, or another type."""
    return float(value) if isinstance(value, int | float) else None


def vector_of(value: Any, width: int) -> Array | None:
    """(width,) the numbers of one vector; None where there is no value, or another type."""
    found = array_of(None if value is None else [value], np.float64, width)
    return found[0] if len(found) else None


def numbers(attribute: Usd.Attribute, width: int | None = None) -> Array:
    """(N, width) the numbers of an attribute, or (N,)."""
    return array_of(attribute.Get(TIME), np.float64, width)


def integers(attribute: Usd.Attribute, width: int | None = None) -> Ints:
    """(N, width) the whole numbers of an attribute, or (N,)."""
    return array_of(attribute.Get(TIME), np.int64, width)
