"""Work of one caller on several threads."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

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
