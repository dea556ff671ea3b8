"""What a pickle of unknown origin may refer to: the names by which numpy stores numbers.

Reading a name does nothing; the calls below stand for numpy's, and check what they are given.
"""

import re
from collections.abc import Callable
from typing import Any, Final

import numpy as np

_NUMERIC: Final = re.compile(r"([<>|=]?)(b1|[iu][1248]|f[248])")


class Name:
    """An admitted global; reading one does nothing."""

    def __init__(self, path: str) -> None:
        self.path = path


class Blank:
    """An array that was announced and not yet filled."""


class RefusedError(Exception):
    """What stands in a pickle is not admitted."""


# Under the names of numpy 1 and of numpy 2.
NAMES: Final = {
    f"{module}.{name}": name
    for module in ("numpy.core.multiarray", "numpy._core.multiarray")
    for name in ("_reconstruct", "scalar")
} | {"numpy.ndarray": "ndarray", "numpy.dtype": "dtype", "_codecs.encode": "encode"}


def _dtype(kind: Any, *_: Any) -> np.dtype[Any]:
    if not isinstance(kind, str) or not _NUMERIC.fullmatch(kind):
        raise RefusedError(f"arrays of the type {kind!r}")
    return np.dtype(kind)


def ordered(dtype: np.dtype[Any], state: Any) -> np.dtype[Any]:
    """A type with the byte order that its state says."""
    if len(state) < 5 or state[1] not in ("<", ">", "|", "=") or any(state[2:5]):
        raise RefusedError("a type of records")
    return dtype if state[1] == "|" else dtype.newbyteorder(state[1])


def _blank(kind: Any, shape: Any, code: Any) -> Blank:
    if not isinstance(kind, Name) or kind.path != "ndarray":
        raise RefusedError("a kind of array")
    return Blank()


def filled(state: Any) -> Any:
    """The array that a state describes."""
    _, shape, dtype, fortran, stored = state
    data = _raw(stored)
    if not isinstance(dtype, np.dtype) or data is None:
        raise RefusedError("an array without numbers")
    values = np.frombuffer(data, dtype)
    return values.reshape(shape, order="F" if fortran else "C")


def _scalar(dtype: Any, stored: Any) -> Any:
    data = _raw(stored)
    if not isinstance(dtype, np.dtype) or data is None:
        raise RefusedError("a scalar without a number")
    (value,) = np.frombuffer(data, dtype).tolist()
    return value


def _raw(stored: Any) -> bytes | None:
    """Bytes as they are; those of Python 2 are read as text."""
    if isinstance(stored, str):
        return stored.encode("latin-1")
    return stored if isinstance(stored, bytes) else None


def _encode(text: Any, encoding: Any) -> bytes:
    if not isinstance(text, str) or encoding != "latin1":
        raise RefusedError("an encoding")
    return text.encode("latin-1")


CALLS: Final[dict[str, Callable[..., Any]]] = {
    "_reconstruct": _blank,
    "scalar": _scalar,
    "dtype": _dtype,
    "encode": _encode,
}
