"""The contract between a run and the workers of its tasks: processes, or other machines.

Tasks and their events are plain data, so that they can go anywhere.
"""

import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any, Final, Protocol, TypeVar

Task = Mapping[str, Any]
"""What there is to do, as JSON has it."""

WorkerMessage = Mapping[str, Any]
"""What a worker says of its task while it works, as JSON has it."""

Work = Callable[[Task], Iterator[WorkerMessage]]
"""A function of a module: it does what a task asks, and says so."""


@dataclass(frozen=True)
class Lost:
    """A worker that died over its task.

    Attributes:
        reason: What is known of it, for people.
    """

    reason: str


@dataclass(frozen=True)
class WorkerDemand:
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

    def run(self, tasks: Iterable[Task], work: Work) -> Iterator[tuple[Task, WorkerMessage | Lost]]:
        """Work tasks off, several at once.

        Tasks are taken when a worker is free, and not before. A worker that dies is reported as
        `Lost` and replaced; its task is not started again. When the caller stops, so do the
        workers.

        Args:
            tasks: What there is to do.
            work: The function that does it; exceptions are reported as `Lost`.

        Yields:
            A task and its events, as they happen; those of one task in order.
        """
        ...


class Executor(Protocol):
    """Hires workers; an entry point ``openrooms_usd.executors``.

    Attributes:
        options: What may be asked of it, for people, by name.
    """

    options: Mapping[str, str]

    def hired(self, wanted: WorkerDemand) -> AbstractContextManager[Crew]:
        """Workers, as long as the block lasts.

        Raises:
            InputError: An option is wrong, or there is no place for such workers.
            MissingPackageError: It needs a package that is not installed.
        """
        ...


# How workers of any kind get their tasks: one each, the next when it is done, another who died.

# What a worker sends: events of its task, that it is done, or that it could not go on.
TOLD: Final = "told"
DONE: Final = "done"
RAISED: Final = "raised"
# prctl(2): the signal that a process gets when its parent ends.
_PR_SET_PDEATHSIG: Final = 1


class Worker(Protocol):
    """A worker on one task.

    Attributes:
        task: What it works on.
    """

    task: Task

    def hear(self) -> WorkerMessage | Lost | None:
        """What it says next; None when it is done with its task."""
        ...

    def give(self, task: Task) -> bool:
        """Give it another task; whether it is there to take it."""
        ...

    def stop(self) -> None:
        """End it, whatever it is doing."""
        ...


AnyWorker = TypeVar("AnyWorker", bound=Worker)


def worked_off(
    tasks: Iterable[Task],
    workers: int,
    hire: Callable[[Task], AnyWorker],
    ready: Callable[[list[AnyWorker]], list[AnyWorker]],
) -> Iterator[tuple[Task, WorkerMessage | Lost]]:
    """Have tasks worked off by so many workers at once; see `executor.Crew.run`.

    Args:
        tasks: The tasks; one is taken when a worker is free.
        workers: How many there are at most.
        hire: Begins a worker with its first task.
        ready: Waits until some of the workers have something to say; which they are.

    Yields:
        A task and its event.
    """
    waiting = iter(tasks)
    crew: list[AnyWorker] = []
    try:
        for task in waiting:
            crew.append(hire(task))
            if len(crew) == max(1, workers):
                break
        while crew:
            for worker in ready(crew):
                heard = worker.hear()
                if heard is not None:
                    yield worker.task, heard
                if heard is None or isinstance(heard, Lost):
                    following = next(waiting, None)
                    if following is not None and worker.give(following):
                        continue
                    crew.remove(worker)
                    worker.stop()
                    if following is not None:
                        crew.append(hire(following))
    finally:
        for worker in crew:
            worker.stop()


def messages(work: Work, task: Task) -> Iterator[tuple[str, Any]]:
    """What a worker sends of a task, in this order: all events, and how it ended."""
    try:
        for told in work(task):
            yield TOLD, dict(told)
    except Exception as error:
        yield RAISED, f"{type(error).__name__}: {error}"
    else:
        yield DONE, None


def understood(message: tuple[str, Any]) -> WorkerMessage | Lost | None:
    """What a message says; None when a task is done."""
    kind, what = message
    if kind == RAISED:
        return Lost(str(what))
    told: WorkerMessage = what
    return told if kind == TOLD else None


def end_with_parent() -> None:
    """End this process at once when the one that started it is gone, however it went.

    Where there is no such thing (macOS, Windows), nothing happens.
    """
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
