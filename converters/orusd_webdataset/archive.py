"""POSIX tar files: the same bytes for the same files, whoever writes them and when."""

import io
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from openrooms_usd import atomic, untrusted
from openrooms_usd.errors import writing

BLOCK: Final = 512
_MODE: Final = 0o644


class Archive:
    """A tar file that is being written.

    Args:
        file: Where it goes.
    """

    def __init__(self, file: tarfile.TarFile) -> None:
        self._file = file

    def add_text(self, name: str, text: str) -> None:
        """Add a file of text."""
        data = text.encode()
        self._file.addfile(_header(name, len(data)), io.BytesIO(data))

    def add_file(self, name: str, path: Path) -> None:
        """Add a copy of a file.

        Raises:
            InputError: It cannot be read.
        """
        with untrusted.opened(path, "frames", remedy="render again") as stream:
            self._file.addfile(_header(name, path.stat().st_size), stream)


@contextmanager
def archive(path: Path) -> Iterator[Archive]:
    """A tar file that appears whole, or not at all.

    Raises:
        OutputError: It cannot be written.
    """
    with (
        atomic.replacing(path) as beside,
        writing(path),
        # Long names get a header of their own, without a time.
        tarfile.open(beside, "w", format=tarfile.PAX_FORMAT) as file,
    ):
        yield Archive(file)


def room_for(size: int) -> int:
    """The bytes that a file of a size takes in an archive, with its header."""
    return BLOCK + -(-size // BLOCK) * BLOCK


def _header(name: str, size: int) -> tarfile.TarInfo:
    # Its time, owner and group are 0 already.
    header = tarfile.TarInfo(name)
    header.size, header.mode = size, _MODE
    return header
