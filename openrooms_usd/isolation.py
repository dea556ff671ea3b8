"""Formats whose libraries can end a process are read in another process first.

Some readers are maps of memory, or take what a file claims at its word: a few wrong bytes end the
whole process, or let it run or grow without end. No look at the bytes foresees all of it. So
another process tries first, within limits of time and memory, and stays for the next file.

A module that reads in this way calls `serve` when it is run (``python -m``); who is about to read
calls `check_reads` with the module's name.
"""

import atexit
import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from math import inf
from pathlib import Path
from typing import IO, Final

from openrooms_usd.errors import InputError

_MIB: Final = 1 << 20
_MOST_MEMORY_BYTES: Final = 2048 * _MIB
_START_SECONDS: Final = 60.0
_LEAST_SECONDS: Final = 10.0
# A process that waits for others on a busy machine has so many times as long.
_MOST_WAITING: Final = 10.0
# Slow disks and slow machines; real files are read at many MiB a second.
_SLOWEST_BYTES_PER_SECOND: Final = 2 * _MIB
# What the process answers.
_READY: Final = "ready"
_READ: Final = "read"
_MEMORY: Final = "memory"


def check_reads(module: str, name: str, size: int, *, what: str, place: str = "") -> None:
    """See that another process can read a file, and lives.

    Where no other process can be had (Python within another program), nothing is tried.

    Args:
        module: The module whose process reads.
        name: The file, as the module understands it.
        size: How many bytes it has.
        what: The format, for messages.
        place: What messages call the file; ``name`` by default.

    Raises:
        InputError: The process crashed, hung, or took too much memory.
    """
    reader = _reader(module)
    with reader.lock:
        answer = reader.ask(name, _LEAST_SECONDS + size / _SLOWEST_BYTES_PER_SECOND)
    if answer in (_READ, None):
        return
    raise InputError(
        f"not a readable {what} file: {answer}",
        place=place or name,
        remedy="copy it again, or export it again",
    )


def serve(read: Callable[[str], None]) -> None:
    """Serve requests until the pipe closes.

    Args:
        read: Reads a file. What it raises is for the one who asks, and comes up there again.
    """
    with suppress(ImportError, OSError, ValueError):  # not everywhere, and not above a lower limit
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (_MOST_MEMORY_BYTES, _MOST_MEMORY_BYTES))
    # What libraries print is not an answer.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    print(_READY, file=answers, flush=True)
    for line in sys.stdin:
        answer = _READ
        try:
            read(json.loads(line))
        except MemoryError:
            answer = _MEMORY
        except Exception:
            pass
        print(answer, file=answers, flush=True)


class _Reader:
    """The process that reads, started when it is first needed and after each of its ends.

    Args:
        module: What it runs.
    """

    def __init__(self, module: str) -> None:
        self.lock = threading.Lock()
        self._module = module
        self._process: subprocess.Popen[str] | None = None
        self._answers = queue.SimpleQueue[str]()
        self._owner = 0

    def ask(self, name: str, seconds: float) -> str | None:
        """What became of a file: ``read``, or what went wrong; None where nothing was tried."""
        if not self._is_there():
            self._start()
        process = self._process
        if process is None or process.stdin is None:
            return None
        begun = self._worked()
        try:
            process.stdin.write(f"{json.dumps(name)}\n")
            process.stdin.flush()
        except OSError:
            self.stop()
            return "it crashes the process that reads it"
        answer, waited = self._answer(seconds), seconds
        while (
            answer is None and waited < _MOST_WAITING * seconds and self._worked() - begun < seconds
        ):
            answer, waited = self._answer(seconds), waited + seconds
        if answer == _MEMORY:
            return "it needs more memory than is available"
        if answer == _READ:
            return answer
        is_hung = process.poll() is None and answer is None
        self.stop()
        return "reading it takes too long" if is_hung else "it crashes the process that reads it"

    def _worked(self) -> float:
        """Seconds of processor that it has used so far; infinite if unknown."""
        if self._process is None or self._process.poll() is not None:
            return inf
        try:
            told = Path(f"/proc/{self._process.pid}/stat").read_text(encoding="utf-8")
        except OSError:
            return inf
        # After its name, which may hold anything, comes its state as field 3.
        fields = told.rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def stop(self) -> None:
        """End the process, if it is this one's."""
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return
        process.kill()
        process.wait()
        with suppress(OSError):
            if process.stdin:
                process.stdin.close()

    def _is_there(self) -> bool:
        # A process that was forked off shares the pipes of its parent, and must not use them.
        return (
            self._process is not None
            and self._owner == os.getpid()
            and self._process.poll() is None
        )

    def _start(self) -> None:
        self.stop()
        # -P: files in the current folder are not our modules, and must not be imported.
        command = [sys.executable, "-P", "-m", self._module]
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
        try:
            self._process = subprocess.Popen(
                command, stdin=pipe, stdout=pipe, stderr=nowhere, text=True, env=env
            )
        except (OSError, ValueError):
            return
        self._owner = os.getpid()
        self._answers = queue.SimpleQueue()
        told = (self._process.stdout, self._answers)
        threading.Thread(target=_pass_on, args=told, daemon=True).start()
        if self._answer(_START_SECONDS) != _READY:
            self.stop()

    def _answer(self, seconds: float) -> str | None:
        """The next line; None after some time, empty at the end of the process."""
        try:
            return self._answers.get(timeout=seconds)
        except queue.Empty:
            return None


def _pass_on(stream: IO[str], answers: "queue.SimpleQueue[str]") -> None:
    """Hand lines over as they come, since Windows cannot wait for a pipe; at its end, nothing."""
    with suppress(OSError, ValueError), stream:
        for line in stream:
            answers.put(line.strip())
    answers.put("")


@cache
def _reader(module: str) -> _Reader:
    reader = _Reader(module)
    atexit.register(reader.stop)
    return reader
