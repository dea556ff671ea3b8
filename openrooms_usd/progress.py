"""How what takes long says how far it is: one shape for all of it."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

Progress = Callable[[str, float], None]
"""Called with what is being worked on and the finished fraction of the whole, from 0 to 1."""


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
    return lambda fraction: progress(what, (index + min(max(fraction, 0.0), 1.0)) / count)


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


# Work of one caller on several threads.

_Item = TypeVar("_Item")
_Made = TypeVar("_Made")


def mapped(work: Callable[[_Item], _Made], items: Iterable[_Item], workers: int) -> Iterator[_Made]:
    """What work makes of each item, in the order of the items, in the caller's context.

    Args:
        work: Called with an item, in any thread.
        items: What there is to do.
        workers: How many threads; fewer than one are one.

    Raises:
        Exception: Whatever ``work`` raises first, in the order of the items.
    """
    with ThreadPoolExecutor(max(workers, 1)) as pool:
        waiting = [pool.submit(copy_context().run, work, item) for item in items]
        for each in waiting:
            yield each.result()
