"""JSON, CSV and single values of unknown origin: read with limits, mistakes with their place."""

import csv
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array
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
            InputError: It is not a list.
        """
        found = self.get(key)
        if found is None:
            return []
        if not isinstance(found.value, list):
            raise found.error(f"a list expected, found {_kind(found.value)}")
        return [Node(value, self.file, f"{found.path}[{i}]") for i, value in enumerate(found.value)]

    def numbers(self, count: int, largest: float) -> Array:
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
        remedy="give the complete exported JSON file, unchanged",
    )


# Single values of foreign records, checked: texts, numbers, choices and identifiers.

_MAX_CHARACTERS: Final = 200  # characters of an identifier or a label
_REMEDY: Final = "correct this value"


def text(node: Node) -> str:
    """A printable text or a whole number, as a text.

    Raises:
        InputError: It is something else, empty, or too long.
    """
    value = node.value
    found = str(value) if isinstance(value, int) and not isinstance(value, bool) else value
    if not isinstance(found, str) or not found.strip() or not found.isprintable():
        raise node.error("a text expected", _REMEDY)
    if len(found) > _MAX_CHARACTERS:
        raise node.error(
            f"{len(found)} characters are too long (at most {_MAX_CHARACTERS})", _REMEDY
        )
    return found.strip()


def number(node: Node, largest: float) -> float:
    """A finite number.

    Raises:
        InputError: It is not a number, or absurd.
    """
    return float(node.numbers(1, largest)[0])


def positive(node: Node, largest: float) -> float:
    """A number above zero.

    Raises:
        InputError: It is not a number, or it is zero, negative or absurd.
    """
    found = number(node, largest)
    if found <= 0.0:
        raise node.error(f"{found:g} is not a size: it must be above zero", _REMEDY)
    return found


def flag(node: Node) -> bool:
    """True or false.

    Raises:
        InputError: It is neither.
    """
    if not isinstance(node.value, bool):
        raise node.error("true or false expected", _REMEDY)
    return node.value


def choice(node: Node, known: Sequence[str]) -> str:
    """One of some words.

    Raises:
        InputError: It is not one of them.
    """
    found = text(node)
    if found not in known:
        raise node.error(f"{found[:40]!r} is not one of: {', '.join(known)}", _REMEDY)
    return found


def identifiers(nodes: Sequence[Node], kind: str) -> list[str]:
    """The identifier of every record: its ``id``, or what it is and its place in the list.

    Raises:
        InputError: One appears twice.
    """
    first: dict[str, Node] = {}
    found: list[str] = []
    for index, node in enumerate(nodes):
        given = node.get("id")
        identifier = text(given) if given else f"{kind}{index}"
        if (other := first.setdefault(identifier, node)) is not node:
            raise node.error(
                f"the id {identifier!r} repeats that of {other.path}", "give each its own id"
            )
        found.append(identifier)
    return found


# CSV tables of unknown origin: read with limits, every mistake with its line.


def read_table(path: Path, need: Sequence[str], texts: Sequence[str] = ()) -> list[Node]:
    """Read a CSV file with a header.

    Args:
        path: The file; comma, semicolon or tab between the fields.
        need: Columns that must be there. Others become fields too.
        texts: Columns whose fields stay texts; elsewhere what looks like a number is one.

    Returns:
        An object for each row that is not empty; its place is its line.

    Raises:
        InputError: It is missing, no regular file, too large, or a column is missing.
    """
    lines = untrusted.read_text(path, "table").splitlines(keepends=True)
    separator = max(",;\t", key=lines[0].count) if lines else ","
    rows = csv.reader(lines, delimiter=separator, strict=True)
    try:
        return list(_records(rows, path, need, texts))
    except csv.Error as error:
        raise InputError(
            f"not readable as CSV: {error}",
            place=f"{path}: line {rows.line_num}",
            remedy="save the table again as CSV, UTF-8",
        ) from error


def _records(
    rows: Iterator[list[str]], path: Path, need: Sequence[str], texts: Sequence[str]
) -> Iterator[Node]:
    header = [name.strip().lower() for name in next(rows, [])]
    top = Node(None, path, "line 1")
    if missing := [name for name in need if name not in header]:
        raise top.error(
            f"the header lacks {', '.join(missing)}",
            f"the first line names the columns, at least: {', '.join(need)}",
        )
    if repeated := {name for name, times in Counter(header).items() if name and times > 1}:
        raise top.error(f"the header repeats {', '.join(sorted(repeated))}", "name each once")
    for row in rows:
        # csv counts the lines itself: fields in quotes may hold line ends.
        line = rows.line_num  # type: ignore[attr-defined]
        if not any(field.strip() for field in row):
            continue
        node = Node(None, path, f"line {line}")
        if len(row) != len(header):
            raise node.error(f"{len(header)} fields expected, found {len(row)}", "correct the line")
        fields = {name: field.strip() for name, field in zip(header, row, strict=True)}
        yield Node({n: _value(f, n in texts) for n, f in fields.items()}, path, node.path)


def _value(field: str, is_text: bool) -> float | str | None:
    """A number where it may be and is one, else a text; nothing where the field is empty."""
    if is_text:
        return field or None
    try:
        return float(field)
    except ValueError:
        return field or None
