"""Commands in processes of their own: what they take, and how much memory they had at most."""

import os
import sys
import tempfile
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Ran:
    """A finished process.

    Attributes:
        seconds: Of all cores.
        elapsed: By the clock.
        peak_gib: The most memory that it had at once.
        said: What it printed.
    """

    seconds: float
    elapsed: float
    peak_gib: float
    said: str


def run(*words: object, **environment: str) -> Ran:
    """Run a command and wait for it.

    Raises:
        SystemExit: It failed; with what it said.
    """
    command = [str(word) for word in words]
    with tempfile.TemporaryFile() as said:
        began = time.perf_counter()
        child = os.posix_spawnp(
            command[0], command, {**os.environ, **environment},
            file_actions=[(os.POSIX_SPAWN_DUP2, said.fileno(), 1),
                          (os.POSIX_SPAWN_DUP2, said.fileno(), 2)],
        )  # fmt: skip
        _, status, used = os.wait4(child, 0)
        elapsed = time.perf_counter() - began
        said.seek(0)
        text = said.read().decode(errors="replace")
    if status:
        raise SystemExit(f"{' '.join(command)} failed:\n{text}")
    # Linux counts in KiB, macOS in bytes.
    peak = used.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    return Ran(used.ru_utime + used.ru_stime, elapsed, peak / 2**30, text)
