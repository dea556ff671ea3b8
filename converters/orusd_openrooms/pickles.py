"""Pickles that the loaders of the released dataset demand, written without executing anything.

Protocol 2, which every Python since 2.3 reads; arrays by the names that every numpy 1 has and
numpy 2 still knows. Only plain data can be written: None, truth, numbers, texts, lists, tuples,
dictionaries and numeric arrays.
"""

import struct
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic
from openrooms_usd.rendering.manifest import write_json

_RECONSTRUCT: Final = b"cnumpy.core.multiarray\n_reconstruct\n"
_NDARRAY: Final = b"cnumpy\nndarray\n"
_DTYPE: Final = b"cnumpy\ndtype\n"
_ENCODE: Final = b"c_codecs\nencode\n"
_NUMERIC: Final = "biuf"


def write_pickled(path: Path, value: Any) -> None:
    """Write plain data as a pickle, and as JSON beside it.

    Args:
        path: The pickle; the JSON file has its name and the suffix ``.json``.
        value: The data.

    Raises:
        OutputError: A file cannot be written.
    """
    atomic.write_bytes(path, pickled(value))
    write_json(path.with_suffix(".json"), plain(value))


def pickled(value: Any) -> bytes:
    """Plain data as a pickle of protocol 2.

    Raises:
        TypeError: It holds something else than plain data.
    """
    return b"\x80\x02" + _code(value) + b"."


def plain(value: Any) -> Any:
    """The same data for JSON: arrays and tuples become lists."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def _code(value: Any) -> bytes:
    # True is an int, too.
    if value is None or isinstance(value, bool):
        return {None: b"N", True: b"\x88", False: b"\x89"}[value]
    if isinstance(value, int):
        return b"J" + struct.pack("<i", value)
    if isinstance(value, float):
        return b"G" + struct.pack(">d", value)
    if isinstance(value, str):
        text = value.encode()
        return b"X" + struct.pack("<I", len(text)) + text
    if isinstance(value, tuple):
        return b"(" + _joined(value) + b"t"
    if isinstance(value, list):
        return b"](" + _joined(value) + b"e"
    if isinstance(value, dict):
        return b"}(" + _joined(part for pair in value.items() for part in pair) + b"u"
    if isinstance(value, np.ndarray) and value.dtype.kind in _NUMERIC:
        return _array(value)
    raise TypeError(f"not plain data: {type(value).__name__}")


def _joined(values: Any) -> bytes:
    return b"".join(map(_code, values))


def _array(value: NDArray[Any]) -> bytes:
    """``_reconstruct(ndarray, (0,), b"b")`` with the state (version, shape, type, order, bytes)."""
    little = value.astype(value.dtype.newbyteorder("<"))
    kind = little.dtype.str[1:]
    order = little.dtype.str[0]
    made = _DTYPE + _code((kind, False, True)) + b"R"
    dtype = made + _code((3, order, None, None, None, -1, -1, 0)) + b"b"
    state = b"(" + _code(1) + _code(value.shape) + dtype + b"\x89" + _bytes(little.tobytes()) + b"t"
    return _RECONSTRUCT + b"(" + _NDARRAY + _code((0,)) + _bytes(b"b") + b"tR" + state + b"b"


def _bytes(value: bytes) -> bytes:
    """Bytes as text that is encoded again on loading: one form for Python 2 and 3."""
    return _ENCODE + _code((value.decode("latin-1"), "latin1")) + b"R"
