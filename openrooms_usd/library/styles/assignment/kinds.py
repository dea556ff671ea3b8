"""What kind of part a part is: foreign models number, split and spell their parts as they like."""

import re
from collections.abc import Iterator
from typing import Final

_HUMP: Final = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
_BREAK: Final = re.compile(r"[^a-z0-9]+")
_NUMBER: Final = re.compile(r"_?\d+$")


def kind_of(name: str) -> str:
    """A part's kind: its name in our spelling, without the numbers that tell repeats apart.

    ``leg_1``, ``Leg.002`` and ``leg12`` are all of the kind ``leg``, and share one material. A
    name that is nothing but a number has the kind ``""``.
    """
    words = _BREAK.sub("_", _HUMP.sub("_", name).lower()).strip("_")
    while (shorter := _NUMBER.sub("", words)) != words:
        words = shorter
    return words


def known_as(kind: str) -> Iterator[str]:
    """The kinds that a table may have it as, the most special first.

    PartNet says ``chair_leg`` or ``bar_stretcher`` where others say ``leg`` or ``stretcher``: the
    last words are what a thing is.
    """
    words = kind.split("_")
    return ("_".join(words[first:]) for first in range(len(words)))
