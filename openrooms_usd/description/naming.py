"""Default names: ``chair_0``, ``window_1``, stable when other things get names of their own."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import count

from openrooms_usd.description.model import Found


def unique_names(
    wanted: Iterable[tuple[str | None, str]], taken: Collection[str] = ()
) -> list[str]:
    """Name everything that has no name by its kind and a number.

    The numbers of a kind count up in order and skip names that are already used.

    Args:
        wanted: For each thing the name that it was given, or None, and its kind.
        taken: Names that others already have.

    Returns:
        One name each, in order. Given names are kept as they are, also where they repeat.
    """
    rows = list(wanted)
    used = {*taken, *(name for name, _ in rows if name)}
    numbers = {kind: count() for _, kind in rows}
    return [
        name or next(new for n in numbers[kind] if (new := f"{kind}_{n}") not in used)
        for name, kind in rows
    ]


def repeated_names(names: Sequence[str | None], list_key: str, what: str) -> Iterator[Found]:
    """Find names that were given twice.

    Args:
        names: The given names in order, None for what has none.
        list_key: The key of the list that the named things stand in.
        what: What they are, for the message.
    """
    first: dict[str, int] = {}
    for index, name in enumerate(names):
        if name is not None and (seen := first.setdefault(name, index)) != index:
            yield Found(
                (list_key, index, "name"),
                f"{list_key}[{seen}] is already named {name!r}; every {what} needs its own name",
            )
