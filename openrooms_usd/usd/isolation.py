"""Crates of others are read in a process of their own before USD reads them in this one.

Crates are maps of memory: a few wrong bytes end USD's reader, or let it run or grow without end.
No look at the bytes foresees all of it, so another process tries first, within limits of time and
memory. What this program wrote itself, by the ledger of the folder, is read at once.
"""

import atexit
import json
import os
import select
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Final

from openrooms_usd.errors import InputError

_MIB: Final = 1 << 20
_MOST_MEMORY_BYTES: Final = 2048 * _MIB
_START_SECONDS: Final = 60.0
_LEAST_SECONDS: Final = 10.0
# Slow disks and slow machines; real crates are read at hundreds of MiB a second.
_SLOWEST_BYTES_PER_SECOND: Final = 2 * _MIB


def check_crate_reads(name: str, size: int, place: str | None = None) -> None:
    """See that another process can read a crate, and lives.

    Where no other process can be had (Python within another program), nothing is tried.

    Args:
        name: The crate's path, or its place in a package (``/x/y.usdz[z.usdc]``).
        size: How many bytes it has.
        place: What messages call it; ``name`` by default.

    Raises:
        InputError: The process crashed, hung, or took too much memory.
    """
    with _LOCK:
        answer = _READER.ask(name, _LEAST_SECONDS + size / _SLOWEST_BYTES_PER_SECOND)
    if answer in ("read", None):
        return
    raise InputError(
        f"not a readable USD file: {answer}",
        place=place or name,
        remedy="copy it again, or export it again",
    )


class _Reader:
    """The process that reads, started when it is first needed and after each of its ends."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._owner = 0

    def ask(self, name: str, seconds: float) -> str | None:
        """What became of a crate: ``read``, or what went wrong; None where nothing was tried."""
        if not self._is_there():
            self._start()
        process = self._process
        if process is None or process.stdin is None:
            return None
        try:
            process.stdin.write(f"{json.dumps(name)}\n")
            process.stdin.flush()
        except OSError:
            self.stop()
            return "it ends the process that reads it"
        answer = self._answer(seconds)
        if answer in ("read", "memory"):
            return "it takes more memory than there is for it" if answer == "memory" else answer
        is_hung = process.poll() is None and answer is None
        self.stop()
        return "reading it takes too long" if is_hung else "it ends the process that reads it"

    def stop(self) -> None:
        """End the process, if it is this one's."""
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout):
            with suppress(OSError):
                if stream:
                    stream.close()

    def _is_there(self) -> bool:
        # A process that was forked off shares the pipes of its parent, and must not use them.
        return (
            self._process is not None
            and self._owner == os.getpid()
            and self._process.poll() is None
        )

    def _start(self) -> None:
        self.stop()
        script = Path(__file__).with_name("crate_reader.py")
        command = [sys.executable, str(script), str(_MOST_MEMORY_BYTES)]
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
        try:
            self._process = subprocess.Popen(
                command, stdin=pipe, stdout=pipe, stderr=nowhere, text=True, env=env
            )
        except (OSError, ValueError):
            return
        self._owner = os.getpid()
        if self._answer(_START_SECONDS) != "ready":
            self.stop()

    def _answer(self, seconds: float) -> str | None:
        """The next line; None after some time, empty at the end of the process."""
        process = self._process
        if process is None or process.stdout is None:
            return None
        if sys.platform != "win32":  # pipes cannot be waited for there
            ready, _, _ = select.select([process.stdout], [], [], seconds)
            if not ready:
                return None
        return process.stdout.readline().strip()


_READER: Final = _Reader()
_LOCK: Final = threading.Lock()
atexit.register(_READER.stop)
