"""JSON files of unknown origin: read with limits, every mistake with its place."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError


class Node:
    """A value in a JSON file that knows where it stands, for messages.

    Args:
        value: The parsed value.
        file: The file that it is from.
        path: Where it stands there, such as ``walls[3].transform``.
    """

    def __init__(self, value: Any, file: Path, path: str = "") -> None:
        self.value = value
        self.file = file
        self.path = path

    def error(self, message: str, remedy: str | None = None) -> InputError:
        """An error that names this place."""
        place = f"{self.file}: {self.path}" if self.path else str(self.file)
        return InputError(message, place=place, remedy=remedy or "export the capture again")

    def get(self, key: str) -> "Node | None":
        """A member of an object; None when it is missing or null.

        Raises:
            InputError: This is not an object.
        """
        if not isinstance(self.value, dict):
            raise self.error(f"an object expected, found {_kind(self.value)}")
        value = self.value.get(key)
        path = f"{self.path}.{key}" if self.path else key
        return None if value is None else Node(value, self.file, path)

    def need(self, key: str) -> "Node":
        """A member of an object.

        Raises:
            InputError: It is missing.
        """
        found = self.get(key)
        if found is None:
            raise self.error(f"{key!r} is missing")
        return found

    def items(self, key: str) -> list["Node"]:
        """The elements of a list in an object; none when it is missing.

        Raises:
            InputError: It is no list.
        """
        found = self.get(key)
        if found is None:
            return []
        if not isinstance(found.value, list):
            raise found.error(f"a list expected, found {_kind(found.value)}")
        return [Node(value, self.file, f"{found.path}[{i}]") for i, value in enumerate(found.value)]

    def numbers(self, count: int, largest: float) -> NDArray[np.float64]:
        """This list of finite numbers; lists in it are joined, and ``{"x": 1, "y": 2}`` is one.

        Args:
            count: How many there must be.
            largest: The greatest magnitude that makes sense.

        Raises:
            InputError: They are not numbers, not that many, or absurd.
        """
        flat = [x for row in _listed(self.value) for x in _listed(row)]
        if len(flat) != count:
            raise self.error(f"{count} numbers expected, found {len(flat)}")
        for number in flat:
            if isinstance(number, bool) or not isinstance(number, int | float):
                raise self.error(f"a number expected, found {_kind(number)}")
            if not abs(number) <= largest:  # infinities and integers of any length too
                raise self.error(f"{str(number)[:12]} is out of range (at most {largest:g})")
        return np.array(flat, dtype=np.float64)


def _listed(value: Any) -> list[Any]:
    """A list as it is, a vector with named coordinates as one, anything else in one."""
    if isinstance(value, dict) and value and set(value) <= set("xyzw"):
        return [value[axis] for axis in "xyzw" if axis in value]
    return value if isinstance(value, list) else [value]


def _kind(value: Any) -> str:
    kinds = {dict: "an object", list: "a list", str: "a text", bool: "true or false"}
    return kinds.get(type(value), "a number" if value is not None else "nothing")


def read_json(path: Path, kind: untrusted.Kind = "json") -> Node:
    """Read a JSON file; bytes that are not UTF-8 become U+FFFD.

    Args:
        path: The file.
        kind: How much of it there may be: of a capture by default.

    Raises:
        InputError: It is missing, no regular file, too large, not JSON, or nested without end.
    """
    text = untrusted.read_text(path, kind)
    try:
        return Node(json.loads(text, parse_constant=_refuse_constant), path)
    except json.JSONDecodeError as error:
        place = f"{path}:{error.lineno}:{error.colno}"
        raise _not_json(place, error.msg) from error
    except (ValueError, RecursionError) as error:
        reason = "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise _not_json(path, reason) from error


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is not a JSON number")


def _not_json(place: object, reason: str) -> InputError:
    return InputError(
        f"not readable as JSON: {reason}",
        place=place,
        remedy="give the exported JSON file, whole and as it was written",
    )
