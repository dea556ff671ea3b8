"""Pickles of unknown origin, read without executing them.

The standard library's machine, in Python, works off a few of its instructions. Admitted are
numbers, texts, lists, tuples, dictionaries, and the four calls by which numpy stores numeric arrays
and scalars. Every other name or instruction is an error, whatever it would do.

`archives`: ZIP archives, opened by the one door; `arrays`: sizes and shapes, weighed before memory
is taken.
"""

import io
import pickle
import pickletools
import re
import struct
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError

# Deeper nesting than any such file has; it keeps what follows from running out of stack.
_DEEPEST: Final = 32
_NUMERIC: Final = re.compile(r"([<>|=]?)(b1|[iu][1248]|f[248])")
_DAMAGE: Final = (
    *(ValueError, TypeError, LookupError, OverflowError, AttributeError, EOFError),
    *(struct.error, pickle.UnpicklingError),
)


class RefusedError(Exception):
    """What stands in a pickle is not admitted."""


def read_pickled(path: Path) -> Any:
    """Read a pickle that holds plain data and numeric arrays.

    Args:
        path: The file.

    Returns:
        None, truth values, numbers, texts, lists, tuples, dictionaries and arrays.

    Raises:
        InputError: It cannot be read, is not a pickle, or holds anything else.
    """
    try:
        return unpickled(untrusted.read_bytes(path, "pickle"))
    except RefusedError as error:
        raise InputError(
            f"not a pickle of plain data: {error}",
            place=path,
            remedy="do not load it by other means unless you trust its author",
        ) from error


def unpickled(data: bytes) -> Any:
    """The value of a pickle.

    Raises:
        RefusedError: It holds something that is not admitted, or is damaged.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # odd escapes in damaged texts
            return _Machine(data).value()
    except _DAMAGE as error:
        raise RefusedError(f"it is damaged ({error})") from error


class _Type:
    """A numpy type of numbers, and the order of its bytes."""

    def __init__(self, kind: Any, *_: Any) -> None:
        if not isinstance(kind, str) or not _NUMERIC.fullmatch(kind):
            raise RefusedError(f"arrays of the type {kind!r}")
        self.dtype = np.dtype(kind)

    def fill(self, state: Any) -> None:
        if len(state) < 5 or state[1] not in ("<", ">", "|", "=") or any(state[2:5]):
            raise RefusedError("a type of records")
        if state[1] != "|":
            self.dtype = self.dtype.newbyteorder(state[1])

    def numbers(self, stored: Any) -> np.ndarray[Any, Any]:
        """What bytes hold; those of Python 2 are read as text."""
        data = stored.encode("latin-1") if isinstance(stored, str) else stored
        return np.frombuffer(data, self.dtype)

    def scalar(self, stored: Any) -> Any:
        (value,) = self.numbers(stored).tolist()
        return value


class _Array:
    """An array that is announced first and filled later."""

    values: np.ndarray[Any, Any] | None = None

    def __init__(self, kind: Any, shape: Any, code: Any) -> None:
        if kind is not np.ndarray:
            raise RefusedError("a kind of array")

    def fill(self, state: Any) -> None:
        _, shape, kind, fortran, stored = state
        self.values = kind.numbers(stored).reshape(shape, order="F" if fortran else "C")


def _encode(text: Any, encoding: Any) -> bytes:
    if not isinstance(text, str) or encoding != "latin1":
        raise RefusedError("an encoding")
    return text.encode("latin-1")


# What stands in place of numpy's, under the names of numpy 1 and of numpy 2.
_NAMES: Final[dict[str, Any]] = {
    "numpy.ndarray": np.ndarray,
    "numpy.dtype": _Type,
    "numpy.core.multiarray._reconstruct": _Array,
    "numpy._core.multiarray._reconstruct": _Array,
    "numpy.core.multiarray.scalar": _Type.scalar,
    "numpy._core.multiarray.scalar": _Type.scalar,
    "_codecs.encode": _encode,
}
_CALLS: Final = (_Type, _Array, _Type.scalar, _encode)


class _Memory(dict[int, Any]):
    """What a pickle refers to again: no collection, which may hold itself or unfold without end."""

    def __getitem__(self, place: int) -> Any:
        value = super().__getitem__(place)
        if isinstance(value, list | tuple | dict):
            raise RefusedError("a collection that is referred to again")
        return value


class _Machine(pickle._Unpickler):
    """The library's machine, without the instructions that could do or change anything."""

    # What its type hints leave out.
    stack: list[Any]
    metastack: list[Any]
    append: Callable[[Any], None]
    pop_mark: Callable[[], list[Any]]

    def __init__(self, data: bytes) -> None:
        super().__init__(io.BytesIO(data), encoding="latin1")
        self.memo = _Memory()

    def value(self) -> Any:
        found = self.load()
        if self.stack or self.metastack:
            raise RefusedError("more than one value")
        return _plain(found, 0)

    def find_class(self, module: str, name: str) -> Any:
        """Stand-ins for the admitted names; nothing is imported."""
        path = f"{module}.{name}"
        if path not in _NAMES:
            raise RefusedError(f"the name {path!r}")
        return _NAMES[path]

    def call(self) -> None:
        """Call a stand-in."""
        arguments, function = self.stack.pop(), self.stack.pop()
        if function not in _CALLS or not isinstance(arguments, tuple):
            raise RefusedError("a call")
        self.append(function(*arguments))

    def build(self) -> None:
        """Give a stand-in its state."""
        state, made = self.stack.pop(), self.stack[-1]
        if not isinstance(made, _Type | _Array):
            raise RefusedError("an object")
        made.fill(state)

    def set_items(self, items: list[Any]) -> None:
        """Fill a dictionary; hashing a key that is a collection could take for ever."""
        if not isinstance(self.stack[-1], dict) or len(items) % 2:
            raise RefusedError("elements without a collection")
        if not all(isinstance(key, str | int | float) for key in items[::2]):
            raise RefusedError("a key that is neither text nor number")
        self.stack[-1].update(zip(items[::2], items[1::2], strict=True))

    def extend(self, items: list[Any]) -> None:
        """Fill a list."""
        if not isinstance(self.stack[-1], list):
            raise RefusedError("elements without a collection")
        self.stack[-1].extend(items)

    def pop_two(self) -> list[Any]:
        value, key = self.stack.pop(), self.stack.pop()
        return [key, value]

    def make_dict(self) -> None:
        """Make a dictionary of what stands since the mark."""
        items = self.pop_mark()
        self.append({})
        self.set_items(items)


class _Instructions(dict[int, Callable[[Any], None]]):
    """What the machine does, by the code of an instruction."""

    def __missing__(self, code: int) -> Callable[[Any], None]:
        known = (one.name for one in pickletools.opcodes if one.code == chr(code))
        raise RefusedError(f"the instruction {next(known, code)}")


# Those that only put plain values together, as the library has them.
_PLAIN: Final = (
    "PROTO FRAME STOP MARK NONE NEWTRUE NEWFALSE INT BININT BININT1 BININT2 LONG LONG1 LONG4 FLOAT"
    " BINFLOAT UNICODE SHORT_BINUNICODE BINUNICODE BINUNICODE8 SHORT_BINBYTES BINBYTES BINBYTES8"
    " STRING BINSTRING SHORT_BINSTRING EMPTY_LIST EMPTY_DICT EMPTY_TUPLE TUPLE TUPLE1 TUPLE2 TUPLE3"
    " LIST PUT BINPUT LONG_BINPUT MEMOIZE GET BINGET LONG_BINGET GLOBAL STACK_GLOBAL"
)
_CODES: Final = {name: getattr(pickle, name)[0] for name in _PLAIN.split()}
_Machine.dispatch = _Instructions(
    {code: pickle._Unpickler.dispatch[code] for code in _CODES.values()}
    | {
        pickle.REDUCE[0]: _Machine.call,
        pickle.BUILD[0]: _Machine.build,
        pickle.DICT[0]: _Machine.make_dict,
        pickle.APPEND[0]: lambda machine: machine.extend([machine.stack.pop()]),
        pickle.APPENDS[0]: lambda machine: machine.extend(machine.pop_mark()),
        pickle.SETITEM[0]: lambda machine: machine.set_items(machine.pop_two()),
        pickle.SETITEMS[0]: lambda machine: machine.set_items(machine.pop_mark()),
    }
)


def _plain(value: Any, depth: int) -> Any:
    """Only finished plain values leave; a name or a blank array does not."""
    if depth > _DEEPEST:
        raise RefusedError("nested too deeply")
    if isinstance(value, dict):
        return {key: _plain(item, depth + 1) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_plain(item, depth + 1) for item in value)
    if isinstance(value, _Array) and value.values is not None:
        return value.values
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise RefusedError(f"a value of the kind {type(value).__name__.strip('_').lower()}")
