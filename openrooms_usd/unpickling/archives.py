"""ZIP archives of unknown origin: opened by the one door, and damage said in words."""

import lzma
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError

MOST_ENTRIES: Final = 100_000
_ENCRYPTED: Final = 0x1
# What zipfile raises for archives that are cut off or changed.
_DAMAGE: Final = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, EOFError, OSError),
    *(RuntimeError, ValueError, OverflowError, MemoryError),
)


@contextmanager
def opened_archive(
    path: Path, kind: untrusted.Kind, *, remedy: str = "export it again"
) -> Iterator[zipfile.ZipFile]:
    """An archive whose names stay in their folder; how much it unpacks to is the caller's to ask.

    Args:
        path: The file.
        kind: What it should be.
        remedy: What to do about one that is damaged.

    Raises:
        InputError: It cannot be read, is damaged (also where that shows in the block), encrypted,
            or has too many files or one that would leave its folder.
    """
    with untrusted.opened(path, kind) as stream:
        try:
            with zipfile.ZipFile(stream) as archive:
                _check(path, archive, remedy)
                yield archive
        except _DAMAGE as error:
            raise InputError(
                f"this archive is damaged: {str(error)[:200] or type(error).__name__}",
                place=path,
                remedy=remedy,
            ) from error


def _check(path: Path, archive: zipfile.ZipFile, remedy: str) -> None:
    entries = archive.infolist()
    if len(entries) > MOST_ENTRIES:
        raise InputError(
            f"{len(entries):,} files are too many (at most {MOST_ENTRIES:,})",
            place=path,
            remedy=remedy,
        )
    for info in entries:
        name = info.filename.replace("\\", "/")
        if name.startswith("/") or ".." in name.split("/") or ":" in name.split("/")[0]:
            raise InputError(
                f"the archive's file {info.filename[:200]!r} would leave its folder",
                place=path,
                remedy=remedy,
            )
        if info.flag_bits & _ENCRYPTED:
            raise InputError(
                f"the archive's file {info.filename[:200]!r} is encrypted",
                place=path,
                remedy="give the archive without a password",
            )
