"""Pickles of unknown origin, read without executing them: their code is interpreted here.

Admitted are numbers, texts, lists, tuples, dictionaries, and the four calls by which numpy stores
numeric arrays and scalars. Every other name or instruction is an error, whatever it would do.

`admitted`: the calls that are no error; `archives`: ZIP archives, opened by the one door;
`arrays`: sizes and shapes, weighed before memory is taken.
"""

import pickletools
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.unpickling.admitted import (
    CALLS,
    NAMES,
    Blank,
    Name,
    RefusedError,
    filled,
    ordered,
)

# Deeper nesting than any such file has; it keeps what follows from running out of stack.
_DEEPEST: Final = 32


class _Mark:
    """Where the elements of a collection begin on the stack."""


def read_pickled(path: Path) -> Any:
    """Read a pickle that holds plain data and numeric arrays.

    Args:
        path: The file.

    Returns:
        None, truth values, numbers, texts, lists, tuples, dictionaries and arrays.

    Raises:
        InputError: It cannot be read, is no pickle, or holds anything else.
    """
    try:
        return unpickled(untrusted.read_bytes(path, "pickle"))
    except RefusedError as error:
        raise InputError(
            f"not a pickle of plain data: {error}",
            place=path,
            remedy="do not load it by other means unless you trust whoever made it",
        ) from error


def unpickled(data: bytes) -> Any:
    """The value of a pickle.

    Raises:
        RefusedError: It holds something that is not admitted, or is damaged.
    """
    machine = _Machine()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # odd escapes in damaged texts
            for opcode, argument, _ in pickletools.genops(data):
                machine.step(opcode.name, argument)
        return machine.result()
    except (ValueError, TypeError, IndexError, KeyError, OverflowError, AttributeError) as error:
        raise RefusedError(f"it is damaged ({error})") from error


class _Machine:
    """The stack and the memory of a pickle's code."""

    def __init__(self) -> None:
        self._stack: list[Any] = []
        self._memo: dict[int, Any] = {}

    def step(self, name: str, argument: Any) -> None:
        if name in _IGNORED:
            return
        if name in _PUSHED:
            self._stack.append(argument)
        elif name in _MADE:
            self._stack.append(_MADE[name]())
        elif name in _ACTIONS:
            _ACTIONS[name](self, argument)
        else:
            raise RefusedError(f"the instruction {name}")

    def result(self) -> Any:
        (value,) = self._stack
        _check(value, 0)
        return value

    def _since_mark(self) -> list[Any]:
        place = max(i for i, item in enumerate(self._stack) if isinstance(item, _Mark))
        found = self._stack[place + 1 :]
        del self._stack[place:]
        return found

    def remember(self, place: Any) -> None:
        self._memo[len(self._memo) if place is None else int(place)] = self._stack[-1]

    def recall(self, place: Any) -> None:
        value = self._memo[int(place)]
        # A collection that is held twice may hold itself, or unfold without end.
        if isinstance(value, list | tuple | dict | Blank):
            raise RefusedError("a collection that is referred to again")
        self._stack.append(value)

    def name(self, argument: Any) -> None:
        if argument is None:
            place = self._stack.pop()
            module = self._stack.pop()
        else:
            module, _, place = argument.partition(" ")
        path = f"{module}.{place}"
        if path not in NAMES:
            raise RefusedError(f"the name {path!r}")
        self._stack.append(Name(NAMES[path]))

    def call(self, argument: Any) -> None:
        arguments, name = self._stack.pop(), self._stack.pop()
        if not isinstance(name, Name) or not isinstance(arguments, tuple):
            raise RefusedError("a call")
        self._stack.append(CALLS[name.path](*arguments))

    def build(self, argument: Any) -> None:
        state, made = self._stack.pop(), self._stack.pop()
        if isinstance(made, np.dtype):
            self._fill(made, ordered(made, state))
        elif isinstance(made, Blank):
            self._fill(made, filled(state))
        else:
            raise RefusedError("an object")

    def _fill(self, made: Any, filled: Any) -> None:
        """Put the finished value in the place of the announced one, in memory, too."""
        self._stack.append(filled)
        self._memo.update({n: filled for n, value in self._memo.items() if value is made})

    def gather(self, size: int | None) -> tuple[Any, ...]:
        if size is None:
            return tuple(self._since_mark())
        found = tuple(self._stack[len(self._stack) - size :])
        if len(found) != size:
            raise RefusedError("too little on the stack")
        del self._stack[len(self._stack) - size :]
        return found

    def push(self, value: Any) -> None:
        self._stack.append(value)

    def extend(self, items: tuple[Any, ...]) -> None:
        owner = self._stack[-1]
        if not isinstance(owner, list):
            raise RefusedError("elements of no list")
        owner.extend(items)

    def update(self, items: tuple[Any, ...]) -> None:
        owner = self._stack[-1]
        if not isinstance(owner, dict):
            raise RefusedError("entries of no dictionary")
        owner.update(_dict(items))


def _dict(items: tuple[Any, ...]) -> dict[Any, Any]:
    if not all(isinstance(key, str | int | float) for key in items[::2]):
        raise RefusedError("a key that is neither text nor number")
    return dict(zip(items[::2], items[1::2], strict=True))


def _check(value: Any, depth: int) -> None:
    """Only finished plain values may leave; a name or a blank array may not."""
    if depth > _DEEPEST:
        raise RefusedError("nested too deeply")
    if isinstance(value, dict):
        value = value.values()
    elif not isinstance(value, list | tuple):
        if value is not None and not isinstance(value, bool | int | float | str | np.ndarray):
            raise RefusedError(f"a value of the kind {type(value).__name__.strip('_').lower()}")
        return
    for item in value:
        _check(item, depth + 1)


_IGNORED: Final = frozenset({"PROTO", "FRAME", "STOP"})
_PUSHED: Final = frozenset({
    "INT", "BININT", "BININT1", "BININT2", "LONG", "LONG1", "LONG4", "FLOAT", "BINFLOAT",
    "UNICODE", "SHORT_BINUNICODE", "BINUNICODE", "BINUNICODE8", "SHORT_BINBYTES", "BINBYTES",
    "BINBYTES8", "STRING", "BINSTRING", "SHORT_BINSTRING",
})  # fmt: skip
_MADE: Final[dict[str, Callable[[], Any]]] = {
    "MARK": _Mark,
    "NONE": lambda: None,
    "NEWTRUE": lambda: True,
    "NEWFALSE": lambda: False,
    "EMPTY_LIST": list,
    "EMPTY_DICT": dict,
    "EMPTY_TUPLE": tuple,
}
_ACTIONS: Final[dict[str, Callable[[_Machine, Any], None]]] = {
    "PUT": _Machine.remember,
    "BINPUT": _Machine.remember,
    "LONG_BINPUT": _Machine.remember,
    "MEMOIZE": _Machine.remember,
    "GET": _Machine.recall,
    "BINGET": _Machine.recall,
    "LONG_BINGET": _Machine.recall,
    "GLOBAL": _Machine.name,
    "STACK_GLOBAL": _Machine.name,
    "REDUCE": _Machine.call,
    "BUILD": _Machine.build,
    "TUPLE": lambda machine, _: machine.push(machine.gather(None)),
    "TUPLE1": lambda machine, _: machine.push(machine.gather(1)),
    "TUPLE2": lambda machine, _: machine.push(machine.gather(2)),
    "TUPLE3": lambda machine, _: machine.push(machine.gather(3)),
    "LIST": lambda machine, _: machine.push(list(machine.gather(None))),
    "DICT": lambda machine, _: machine.push(_dict(machine.gather(None))),
    "APPEND": lambda machine, _: machine.extend(machine.gather(1)),
    "APPENDS": lambda machine, _: machine.extend(machine.gather(None)),
    "SETITEM": lambda machine, _: machine.update(machine.gather(2)),
    "SETITEMS": lambda machine, _: machine.update(machine.gather(None)),
}
