"""Names of what has none: ``chair_0`` where it is described, ``chair_3fa9c1`` where captured.

Both are stable: a name for one renames no other, and what was captured keeps its name in every
import that has it, in whatever order and with whatever else.
"""

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from hashlib import sha256
from itertools import count
from typing import Final

from openrooms_usd.description.model import FoundMistake

# Identifiers that are names themselves. Bare numbers are those of described things.
_SHORT: Final = re.compile(r"(?=.*[A-Za-z])[A-Za-z0-9]{1,8}")
# Hexadecimal digits that stand for a longer identifier, and one that another has already.
_DIGITS: Final = (6, 8, 16, 64)


def unique_names(wanted: Iterable[tuple[str | None, str]]) -> list[str]:
    """Name everything that has no name by its kind and its position among all of that kind.

    Things with names of their own are counted too, so that naming one renames no other. A number
    that a given name uses already is replaced by the next free one, for that thing alone.

    Args:
        wanted: For each thing the name that it was given, or None, and its kind.

    Returns:
        One name each, in order. Given names are kept as they are, also where they repeat.
    """
    rows = list(wanted)
    given = {name for name, _ in rows if name}
    seen, spare = ({kind: count() for _, kind in rows} for _ in range(2))
    places = [f"{kind}_{next(seen[kind])}" for _, kind in rows]
    used = given | {place for place, (name, _) in zip(places, rows, strict=True) if not name}
    return [
        name
        or (place if place not in given else None)
        or next(free for n in spare[kind] if (free := f"{kind}_{n}") not in used)
        for place, (name, kind) in zip(places, rows, strict=True)
    ]


def captured_names(captured: Sequence[tuple[str, str]], taken: Collection[str] = ()) -> list[str]:
    """Name captured things by what they are and by their identifiers in the source.

    Args:
        captured: For each thing a label and its identifier.
        taken: The names of described things, which captured ones make way for.

    Returns:
        One name each, in order, each another: the label with the identifier where that is a short
        word, with the first digits of its SHA-256 otherwise. Only things that are alike in both are
        distinguished by their order.
    """
    names = [_captured_name(label, identifier, 0) for label, identifier in captured]
    for step in range(1, len(_DIGITS)):
        # What is alike in label and identifier stays so whatever the number of digits.
        used = Counter(name for name, _ in set(zip(names, captured, strict=True)))
        clash = [used[name] > 1 or name in taken for name in names]
        names = [
            _captured_name(*thing, step) if again else name
            for thing, name, again in zip(captured, names, clash, strict=True)
        ]
    return _told_apart(names, taken)


def _captured_name(label: str, identifier: str, step: int) -> str:
    if step == 0 and _SHORT.fullmatch(identifier):
        return f"{label}_{identifier}"
    digest = sha256(identifier.encode("utf-8", "surrogatepass")).hexdigest()
    return f"{label}_{digest[: _DIGITS[step]]}"


def _told_apart(names: Sequence[str], taken: Collection[str]) -> list[str]:
    """Names without repetitions: what comes later gets a number behind it."""
    used = {*names, *taken}
    seen: set[str] = set()
    last: Counter[str] = Counter()
    apart = []
    for name in names:
        other = name
        while other in seen or (other != name and other in used):
            last[name] += 1
            other = f"{name}_{last[name]}"
        seen.add(other)
        apart.append(other)
    return apart


def repeated_names(names: Sequence[str | None], list_key: str, what: str) -> Iterator[FoundMistake]:
    """Find names that were given twice.

    Args:
        names: The given names in order, None for what has none.
        list_key: The key of the list that the named things stand in.
        what: What they are, for the message.
    """
    first: dict[str, int] = {}
    for index, name in enumerate(names):
        if name is not None and (seen := first.setdefault(name, index)) != index:
            yield FoundMistake(
                (list_key, index, "name"),
                f"{list_key}[{seen}] is already named {name!r}; every {what} needs its own name",
            )
