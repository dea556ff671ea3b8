"""Works tasks off with processes of this machine."""

import multiprocessing
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import TYPE_CHECKING, Final

from openrooms_usd.dataset.executor import Lost, Task, Told, Work

if TYPE_CHECKING:
    from multiprocessing.context import SpawnProcess

# A worker says so when it is done with its task, or could not go on.
_DONE: Final = "done"
_RAISED: Final = "raised"
_TOLD: Final = "told"
# prctl(2): the signal that a process gets when its parent ends.
_PR_SET_PDEATHSIG: Final = 1
_GRACE_SECONDS: Final = 5.0


class LocalExecutor:
    """One process for each worker, which keeps what it has loaded from task to task.

    Processes are begun anew, not forked: libraries with threads of their own do not survive that.
    """

    def run(
        self, tasks: Iterable[Task], work: Work, workers: int
    ) -> Iterator[tuple[Task, Told | Lost]]:
        """See `openrooms_usd.dataset.executor.Executor.run`."""
        waiting = iter(tasks)
        crew: list[_Worker] = []
        try:
            for task in waiting:
                crew.append(_Worker(work, task))
                if len(crew) == max(1, workers):
                    break
            while crew:
                ready = wait([worker.pipe for worker in crew])
                for worker in [one for one in crew if one.pipe in ready]:
                    heard = worker.hear()
                    if heard is not None:
                        yield worker.task, heard
                    if heard is None or isinstance(heard, Lost):
                        _next(crew, worker, waiting, work)
        finally:
            for worker in crew:
                worker.stop()


def _next(crew: "list[_Worker]", worker: "_Worker", waiting: Iterator[Task], work: Work) -> None:
    """Give a worker that has nothing to do the next task, or let it go; replace one that died."""
    task = next(waiting, None)
    if task is not None and worker.give(task):
        return
    crew.remove(worker)
    worker.stop()
    if task is not None:
        crew.append(_Worker(work, task))


class _Worker:
    """A process and what it is working on."""

    def __init__(self, work: Work, task: Task) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.task = task
        self._process: SpawnProcess = context.Process(
            target=_serve, args=(theirs, work), daemon=True
        )
        self._process.start()
        theirs.close()
        self.pipe.send(dict(task))

    def hear(self) -> Told | Lost | None:
        """What it says next; None when it is done with its task."""
        try:
            kind, what = self.pipe.recv()
        except (EOFError, OSError):
            self._process.join(_GRACE_SECONDS)
            return Lost(f"the worker died ({_ending(self._process.exitcode)})")
        if kind == _RAISED:
            return Lost(str(what))
        told: Told = what
        return told if kind == _TOLD else None

    def give(self, task: Task) -> bool:
        """Give it another task; whether it is there to take it."""
        self.task = task
        with suppress(OSError):
            if self._process.is_alive():
                self.pipe.send(dict(task))
                return True
        return False

    def stop(self) -> None:
        """End it: what it has not finished is swept away by who works there next."""
        with suppress(OSError):
            self.pipe.close()
        self._process.terminate()
        self._process.join(_GRACE_SECONDS)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _ending(code: int | None) -> str:
    if code is not None and code < 0:
        with suppress(ValueError):
            return f"{signal.Signals(-code).name}"
    return f"exit code {code}"


def _serve(pipe: Connection, work: Work) -> None:
    """Work tasks off until there are no more; this is the worker's whole life."""
    _end_with_parent()
    # Who started us stops us: Ctrl-C goes to every process of a terminal.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(EOFError, OSError):
        while True:
            task = pipe.recv()
            try:
                for told in work(task):
                    pipe.send((_TOLD, dict(told)))
            except Exception as error:
                pipe.send((_RAISED, f"{type(error).__name__}: {error}"))
            else:
                pipe.send((_DONE, None))


def _end_with_parent() -> None:
    """End at once when the process that started this one is gone, however it went.

    Its lock is free then, and somebody may go on where it was.
    """
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    threading.Thread(target=_watch_parent, daemon=True).start()


def _watch_parent() -> None:
    import os

    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
