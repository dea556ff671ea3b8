"""Default names: ``chair_0``, ``window_1``, stable when other things get names of their own."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import count

from openrooms_usd.description.model import Found


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
