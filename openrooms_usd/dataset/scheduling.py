"""How workers of any kind get their tasks: one each, the next when it is done, another who died."""

import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Final, Protocol, TypeVar

from openrooms_usd.dataset.executor import Lost, Task, Told, Work

# What a worker sends: what is told of its task, that it is done, or that it could not go on.
TOLD: Final = "told"
DONE: Final = "done"
RAISED: Final = "raised"
# prctl(2): the signal that a process gets when its parent ends.
_PR_SET_PDEATHSIG: Final = 1


class Worker(Protocol):
    """Somebody who works on one task.

    Attributes:
        task: What it works on.
    """

    task: Task

    def hear(self) -> Told | Lost | None:
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
) -> Iterator[tuple[Task, Told | Lost]]:
    """Have tasks worked off by so many workers at once; see `executor.Crew.run`.

    Args:
        tasks: What there is to do; a task is taken when there is somebody for it.
        workers: How many there are at most.
        hire: Begins a worker with its first task.
        ready: Waits until some of the workers have something to say; which they are.

    Yields:
        A task and what is told of it.
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
    """What a worker sends of a task, in this order: all that is told, and how it ended."""
    try:
        for told in work(task):
            yield TOLD, dict(told)
    except Exception as error:
        yield RAISED, f"{type(error).__name__}: {error}"
    else:
        yield DONE, None


def understood(message: tuple[str, Any]) -> Told | Lost | None:
    """What a message says; None when a task is done."""
    kind, what = message
    if kind == RAISED:
        return Lost(str(what))
    told: Told = what
    return told if kind == TOLD else None


def end_with_parent() -> None:
    """End this process at once when the one that started it is gone, however it went.

    Where there is no such thing (macOS, Windows), nothing happens.
    """
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
