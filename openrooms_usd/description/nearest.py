"""The nearest valid name for a typo."""

import difflib
from collections.abc import Iterable
from itertools import islice

# Beyond so many names of about the right length the search would be slow, and a guess worthless.
_MOST = 1000


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """`` (did you mean 'chair'?)``, or nothing where no name is near."""
    about = (name for name in sorted(known) if abs(len(name) - len(word)) <= 3)
    near = difflib.get_close_matches(word, list(islice(about, _MOST)), n=1)
    return f" (did you mean {near[0]!r}?)" if near else ""
