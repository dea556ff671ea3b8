"""The one place where folders for a moment are made."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """An empty folder of the system, for as long as the block lasts.

    What a library still has open on Windows stays in the system's folder of temporary files.
    """
    from tempfile import TemporaryDirectory

    with TemporaryDirectory(prefix="orusd-", ignore_cleanup_errors=True) as name:
        yield Path(name)
