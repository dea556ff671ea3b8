"""Single values of foreign records, checked: texts, numbers, choices and identifiers."""

from collections.abc import Sequence
from typing import Final

from orusd_scans.records.jsonfile import Node

_MAX_CHARACTERS: Final = 200  # characters of an identifier or a label
_REMEDY: Final = "mend this value"


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
        InputError: It is none, or absurd.
    """
    return float(node.numbers(1, largest)[0])


def positive(node: Node, largest: float) -> float:
    """A number above zero.

    Raises:
        InputError: It is none, zero, negative or absurd.
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
        InputError: It is none of them.
    """
    found = text(node)
    if found not in known:
        raise node.error(f"{found[:40]!r} is none of: {', '.join(known)}", _REMEDY)
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
                f"the id {identifier!r} repeats that of {other.path}",
                "give every one an id of its own",
            )
        found.append(identifier)
    return found
