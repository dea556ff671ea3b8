"""Works tasks off with processes of this machine."""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from types import ModuleType
from typing import TYPE_CHECKING, ClassVar, Final

from openrooms_usd.dataset import executor

if TYPE_CHECKING:
    from multiprocessing.context import SpawnProcess

_GRACE_SECONDS: Final = 5.0
# Windows waits for 63 pipes at once.
_MOST_ON_WINDOWS: Final = 60


class LocalExecutor:
    """One process for each worker, which keeps what it has loaded from task to task.

    Processes are begun anew, not forked: libraries with threads of their own do not survive that.
    """

    options: ClassVar[Mapping[str, str]] = {}

    @contextmanager
    def hired(self, wanted: executor.WorkerDemand) -> Iterator["_Crew"]:
        """See `openrooms_usd.dataset.executor.Executor.hired`."""
        workers = max(1, wanted.workers)
        if sys.platform == "win32":
            workers = min(workers, _MOST_ON_WINDOWS)
        yield _Crew(workers, max(1, (os.cpu_count() or 1) // workers))


@dataclass(frozen=True)
class _Crew:
    workers: int
    threads: int

    def run(
        self, tasks: Iterable[executor.Task], work: executor.Work
    ) -> Iterator[tuple[executor.Task, executor.WorkerMessage | executor.Lost]]:
        """See `openrooms_usd.dataset.executor.Crew.run`."""
        return executor.worked_off(tasks, self.workers, lambda task: _Worker(work, task), _ready)


def _ready(crew: "list[_Worker]") -> "list[_Worker]":
    pipes = wait([worker.pipe for worker in crew])
    return [worker for worker in crew if worker.pipe in pipes]


class _Worker:
    """A process and what it is working on."""

    def __init__(self, work: executor.Work, task: executor.Task) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process: SpawnProcess = context.Process(
            target=_serve, args=(theirs, work), daemon=True
        )
        with _without_script():
            self._process.start()
        theirs.close()
        # One that has died already is heard of when it is listened to.
        self.give(task)

    def hear(self) -> executor.WorkerMessage | executor.Lost | None:
        """What it says next; None when it is done with its task."""
        try:
            return executor.understood(self.pipe.recv())
        except (EOFError, OSError):
            self._process.join(_GRACE_SECONDS)
            return executor.Lost(f"the worker died ({_ending(self._process.exitcode)})")

    def give(self, task: executor.Task) -> bool:
        """Give it another task; whether it is there to take it."""
        self.task = task
        with suppress(OSError):
            if self._process.is_alive():
                self.pipe.send(dict(task))
                return True
        return False

    def stop(self) -> None:
        """End it: the next worker there removes what it has not finished."""
        with suppress(OSError):
            self.pipe.close()
        self._process.terminate()
        self._process.join(_GRACE_SECONDS)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


@contextmanager
def _without_script() -> Iterator[None]:
    """A process that begins now does not run the script again that asked for it.

    multiprocessing does so for functions of the script; ours are those of modules.
    """
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


def _ending(code: int | None) -> str:
    if code is not None and code < 0:
        with suppress(ValueError):
            return f"{signal.Signals(-code).name}"
    return f"exit code {code}"


def _serve(pipe: Connection, work: executor.Work) -> None:
    """Work tasks off until there are no more; this is the worker's whole life."""
    # A run that resumes this one finds no worker left.
    executor.end_with_parent()
    threading.Thread(target=_watch_parent, daemon=True).start()
    # Who started us stops us: Ctrl-C goes to every process of a terminal.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(EOFError, OSError):
        while True:
            task = pipe.recv()
            for message in executor.messages(work, task):
                pipe.send(message)


def _watch_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
