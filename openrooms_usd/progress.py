"""How what takes long says how far it is: one shape for all of it."""

from collections.abc import Callable, Iterable, Iterator
from inspect import signature
from typing import Any, Self, TypeVar

Item = TypeVar("Item")

Progress = Callable[[str, float], None]
"""Called with what is being worked on and the finished fraction of the whole, from 0 to 1."""


class Counted(str):
    """The name of what is being worked on, with its number among how many there are."""

    number: int
    total: int

    def __new__(cls, what: str, number: int, total: int) -> Self:
        """Name one of several."""
        named = super().__new__(cls, what)
        named.number, named.total = number, total
        return named

    @property
    def told(self) -> str:
        """The name and the number, for people."""
        return f"{self} ({self.number} of {self.total})" if self.total > 1 else str(self)


def silent(what: str, fraction: float) -> None:
    """Show no progress."""


def part(progress: Progress, what: str, index: int, count: int) -> Callable[[float], None]:
    """The progress of one of several equal parts, as that of the whole.

    Args:
        progress: Of the whole.
        what: What this part works on.
        index: Which part it is, from 0.
        count: How many there are.

    Returns:
        Called with the finished fraction of the part.
    """
    named = Counted(what, index + 1, count)
    return lambda fraction: progress(named, (index + min(max(fraction, 0.0), 1.0)) / count)


def each(progress: Progress, what: str, items: Iterable[Item], count: int) -> Iterator[Item]:
    """Pass on things of about equal work, and say before each how far all of them are.

    Args:
        progress: Of all of them.
        what: What each is called.
        items: The things.
        count: How many there are.
    """
    for number, item in enumerate(items):
        progress(Counted(what, number + 1, count), number / count)
        yield item


def passed_to(function: Callable[..., Any], progress: Progress) -> dict[str, Progress]:
    """The argument ``progress`` for a method of an adapter that has it; for others nothing."""
    return {"progress": progress} if "progress" in signature(function).parameters else {}


def nested(progress: Progress, what: str, begin: float, end: float) -> Progress:
    """The progress of a part that has steps of its own, as that of the whole.

    Args:
        progress: Of the whole.
        what: What this part works on; empty: its steps say enough.
        begin: The fraction of the whole at which it starts, from 0 to 1.
        end: The fraction at which it ends.
    """

    def told(step: str, fraction: float) -> None:
        done = begin + (end - begin) * min(max(fraction, 0.0), 1.0)
        progress(": ".join(filter(None, (what, step))), done)

    return told
