"""Suggestions for misspelt names, and lists of names in sentences."""

import difflib
from collections.abc import Iterable, Mapping, Sequence
from itertools import islice
from typing import Final

# Beyond so many names of about the right length the search would be slow, and a guess worthless.
_MOST: Final = 1000


def nearest(word: str, known: Iterable[str], also: Mapping[str, str] | None = None) -> str | None:
    """The nearest valid name for a typo.

    Args:
        word: What was written; capitals, spaces and hyphens make no difference.
        known: The valid names.
        also: Other words for valid names.

    Returns:
        One of the valid names; None where none is near.
    """
    plain = _plain(word)
    names = {_plain(name): name for name in sorted(known, reverse=True)}
    others = {_plain(other): name for other, name in (also or {}).items()}
    if (exact := names.get(plain) or others.get(plain)) is not None:
        return exact
    about = sorted(name for name in {**others, **names} if abs(len(name) - len(plain)) <= 3)
    near = difflib.get_close_matches(plain, list(islice(about, _MOST)), n=1)
    return (names | {o: n for o, n in others.items() if o not in names})[near[0]] if near else None


def did_you_mean(word: object, known: Iterable[str], also: Mapping[str, str] | None = None) -> str:
    """`` (did you mean 'chair'?)``, or nothing where no name is near: see `nearest`."""
    near = nearest(word, known, also) if isinstance(word, str) else None
    return f" (did you mean {near!r}?)" if near else ""


def listed(names: Sequence[str], most: int) -> str:
    """``a, b and 3 more``: the first of several names, and how many there are besides."""
    more = f" and {len(names) - most:,} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def _plain(word: str) -> str:
    return word.strip().casefold().replace(" ", "_").replace("-", "_")
