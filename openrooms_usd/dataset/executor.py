"""The contract between a run and whoever works its tasks off: processes, or other machines.

Tasks and what is told of them are plain data, so that they can go anywhere.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
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


@dataclass(frozen=True)
class Wanted:
    """Who is wanted.

    Attributes:
        workers: How many tasks shall be worked at once.
        gpus: How many GPUs each of them computes on, unless the options say it.
        options: What is asked of the executor, by name.
    """

    workers: int = 1
    gpus: int = 0
    options: Mapping[str, str] = field(default_factory=dict)


class Crew(Protocol):
    """Workers.

    Attributes:
        threads: How many threads each of them shall use.
    """

    @property
    def threads(self) -> int: ...  # noqa: D102

    def run(self, tasks: Iterable[Task], work: Work) -> Iterator[tuple[Task, Told | Lost]]:
        """Work tasks off, several at once.

        Tasks are taken when a worker is free, and not before. A worker that dies is told as `Lost`
        and replaced; its task is not begun again. When the caller stops, so do the workers.

        Args:
            tasks: What there is to do.
            work: What does it; what it raises is told as `Lost`.

        Yields:
            A task and what is told of it, as it happens; of one task in order.
        """
        ...


class Executor(Protocol):
    """Hires workers; an entry point ``openrooms_usd.executors``.

    Attributes:
        options: What may be asked of it, for people, by name.
    """

    options: Mapping[str, str]

    def hired(self, wanted: Wanted) -> AbstractContextManager[Crew]:
        """Workers, as long as the block lasts.

        Raises:
            InputError: An option is wrong, or there is no place for such workers.
            MissingPackageError: It needs a package that is not installed.
        """
        ...
