"""Collision shapes are searched ahead in several processes, which leave them in the cache.

Python's threads would wait for each other. The processes take the searches one by one from a pipe
that they share, so that all end at about the same time. What is not in the cache afterwards is
searched where it is needed: so nothing depends on how many there are, or whether any can be had.
"""

import io
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, Final, NamedTuple

import numpy as np

from openrooms_usd.errors import InputError
from openrooms_usd.physics.components import Part
from openrooms_usd.physics.decomposition import Method
from openrooms_usd.steps.physics.cache import cached_shapes, is_missing

# Triangles for which it is worth to start another process: they take some seconds.
_WORTH: Final = 10_000
# The most searches in the pipe, and the digits of their numbers: it takes them all at once.
_MOST: Final = 1_000
_DIGITS: Final = 3
# How often a process looks whether the one that started it still lives, seconds.
_PATIENCE_S: Final = 0.5


class Search(NamedTuple):
    """What `cached_shapes` is asked for."""

    parts: Sequence[Part]
    method: Method
    tolerance: float

    @property
    def triangles(self) -> int:
        """About how long it takes."""
        return sum(len(part.triangles) for part in self.parts)


def search_ahead(searches: Sequence[Search], workers: int) -> None:
    """Search what is not in the cache yet, here and in other processes.

    Args:
        searches: What will be needed.
        workers: The most processes, this one included.
    """
    missing = [search for search in searches if is_missing(*search)]
    count = min(workers, sum(search.triangles for search in missing) // _WORTH, len(missing))
    # Windows hands no pipe down to a process by its number.
    if count < 2 or sys.platform == "win32":
        return
    waiting = sorted(missing, key=lambda search: -search.triangles)[:_MOST]
    with _queue(len(waiting)) as queue:
        data = _bytes(waiting)
        processes = [process for _ in range(count - 1) if (process := _started(data, queue))]
        try:
            _search(waiting, queue)
            for process in processes:
                process.wait()
        finally:
            for process in processes:
                process.kill()
                process.wait()


@contextmanager
def _queue(count: int) -> Iterator[int]:
    """A pipe with the numbers below ``count``: each is read once, by any reader."""
    read, write = os.pipe()
    try:
        os.write(write, b"".join(b"%0*d" % (_DIGITS, number) for number in range(count)))
        os.close(write)
        yield read
    finally:
        os.close(read)


def _started(data: bytes, queue: int) -> subprocess.Popen[bytes] | None:
    """A process that searches; None where none can be had."""
    path = os.pathsep.join(filter(None, sys.path))
    # Products of small matrices: threads of a process take from the others what they wait.
    env = {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}
    nowhere = subprocess.DEVNULL
    # -P: files in the current folder are not our modules, and must not be imported.
    command = [sys.executable, "-P", "-m", __name__, str(queue), str(os.getpid())]
    with suppress(OSError, ValueError), tempfile.TemporaryFile() as told:
        told.write(data)
        told.seek(0)
        return subprocess.Popen(
            command, stdin=told, stdout=nowhere, stderr=nowhere, env=env, pass_fds=[queue]
        )
    return None


def _search(waiting: Sequence[Search], queue: int) -> None:
    while number := os.read(queue, _DIGITS):
        with suppress(InputError):  # comes up again where the shapes are needed
            cached_shapes(*waiting[int(number)])


def _bytes(searches: Sequence[Search]) -> bytes:
    told: list[Any] = []
    arrays: dict[str, Any] = {}
    for i, (parts, method, tolerance) in enumerate(searches):
        told.append([[[part.name, part.contact] for part in parts], method, tolerance])
        for k, part in enumerate(parts):
            arrays[f"points_{i}_{k}"] = part.points
            arrays[f"triangles_{i}_{k}"] = part.triangles
    buffer = io.BytesIO()
    np.savez(buffer, searches=np.array(json.dumps(told)), **arrays)
    return buffer.getvalue()


def _parse_searches(data: bytes) -> list[Search]:
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return [
            Search(
                [
                    Part(name, arrays[f"points_{i}_{k}"], arrays[f"triangles_{i}_{k}"], contact)
                    for k, (name, contact) in enumerate(parts)
                ],
                method,
                tolerance,
            )
            for i, (parts, method, tolerance) in enumerate(json.loads(str(arrays["searches"])))
        ]


def _serve(queue: int, parent: int) -> None:
    """Search for another process, as long as it lives: its children outlive it if it is killed."""
    threading.Thread(target=_end_without, args=(parent,), daemon=True).start()
    _search(_parse_searches(sys.stdin.buffer.read()), queue)


def _end_without(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_PATIENCE_S)
    os._exit(1)


if __name__ == "__main__":
    _serve(*map(int, sys.argv[1:]))
