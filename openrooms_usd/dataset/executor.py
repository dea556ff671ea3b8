"""The contract between a run and whoever works its tasks off: processes, or other machines.

Tasks and what is told of them are plain data, so that they can go anywhere.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

Task = Mapping[str, Any]
"""What there is to do, as JSON has it."""

Told = Mapping[str, Any]
"""What a worker says of its task while it works, as JSON has it."""

Work = Callable[[Task], Iterator[Told]]
"""A function of a module: it does what a task asks, and says so."""


@dataclass(frozen=True)
class Lost:
    """A worker that died over its task.

    Attributes:
        reason: What is known of it, for people.
    """

    reason: str


class Executor(Protocol):
    """Works tasks off; an entry point ``openrooms_usd.executors``."""

    def run(
        self, tasks: Iterable[Task], work: Work, workers: int
    ) -> Iterator[tuple[Task, Told | Lost]]:
        """Work tasks off, several at once.

        Tasks are taken when a worker is free, and not before. A worker that dies is told as `Lost`
        and replaced; its task is not begun again. When the caller stops, so do the workers.

        Args:
            tasks: What there is to do.
            work: What does it; what it raises is told as `Lost`.
            workers: How many tasks are worked at once.

        Yields:
            A task and what is told of it, as it happens; of one task in order.
        """
        ...
