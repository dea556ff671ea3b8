"""Notices when other programs change files."""

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final

# Between two looks, seconds.
_PAUSE_S: Final = 0.4

Stamp = tuple[int, int, int] | None


@contextmanager
def watching(files: Sequence[Path], changed: Callable[[Path], None]) -> Iterator[None]:
    """While the block runs, call ``changed`` with each file that was written or replaced.

    Args:
        files: The files; they need not exist yet.
        changed: Called in a thread of its own.
    """
    ended = threading.Event()
    seen = {path: _stamp(path) for path in files}

    def look() -> None:
        while not ended.wait(_PAUSE_S):
            for path, before in seen.items():
                now = _stamp(path)
                if now != before:
                    seen[path] = now
                    changed(path)

    thread = threading.Thread(target=look, daemon=True)
    if files:
        thread.start()
    try:
        yield
    finally:
        ended.set()
        if files:
            thread.join()


def _stamp(path: Path) -> Stamp:
    try:
        told = path.stat()
    except OSError:
        return None
    return told.st_mtime_ns, told.st_size, told.st_ino
