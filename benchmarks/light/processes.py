"""Commands in processes of their own: what they take, and how much memory they had at most."""

import os
import subprocess
import sys
from dataclasses import dataclass
from typing import Final

# A small process in between: what a process had at most, Linux begins with what its parent holds.
_MEASURED: Final = """
import os, sys, time
began = time.perf_counter()
child = os.posix_spawnp(sys.argv[1], sys.argv[1:], os.environ)
_, status, used = os.wait4(child, 0)
print(used.ru_utime + used.ru_stime, time.perf_counter() - began, used.ru_maxrss)
sys.exit(status != 0)
"""


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
    command = [sys.executable, "-S", "-c", _MEASURED, *map(str, words)]
    done = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, **environment}, check=False
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, words))} failed:\n{done.stderr}{done.stdout}")
    said, _, figures = done.stdout.rstrip().rpartition("\n")
    seconds, elapsed, most = map(float, figures.split())
    # Linux counts in KiB, macOS in bytes.
    peak = most * (1 if sys.platform == "darwin" else 1024)
    return Ran(seconds, elapsed, peak / 2**30, said)
