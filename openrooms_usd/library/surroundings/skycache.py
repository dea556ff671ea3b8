"""Panoramas that were made before: in the user's cache, by all that determines them.

An entry is one file, named by a digest: the SHA-256 of the picture's bytes, then these bytes. It
appears whole; one that is damaged is as none. Rooms hardly share panoramas, so few are kept.
"""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

from openrooms_usd import atomic, removal, unfinished
from openrooms_usd.errors import OutputError
from openrooms_usd.usercache import cache_folder

FOLDER: Final = "skies"
"""The folder of the entries, beside that of the textures."""

_SUFFIX: Final = ".sky"
_SUM_BYTES: Final = hashlib.sha256().digest_size
# Those that were used last stay; each has some 8 MB.
_MOST: Final = 32


def cached_picture(key: str, file: Path, write: Callable[[Path], None]) -> None:
    """Have a picture in a file, made only where it must be: the same bytes with and without.

    Args:
        key: A digest of all that determines the picture, code and libraries too.
        file: Where it shall lie.
        write: Makes it, and writes it there.

    Raises:
        OutputError: The file cannot be written.
    """
    folder = cache_folder(FOLDER)
    entry = folder / f"{key}{_SUFFIX}" if folder else None
    found = _content(entry) if entry else None
    if entry and found is not None:
        atomic.write_bytes(file, found)
        # What is used stays longest.
        with suppress(OSError):
            os.utime(entry)
        return
    write(file)
    if entry:
        with suppress(OSError, OutputError):
            data = file.read_bytes()
            entry.parent.mkdir(parents=True, exist_ok=True)
            unfinished.sweep(entry.parent)
            atomic.write_bytes(entry, hashlib.sha256(data).digest() + data)
            _forget(entry.parent)


def _content(entry: Path) -> bytes | None:
    """The picture in an entry; None where there is none, or a damaged one."""
    try:
        data = entry.read_bytes()
    except OSError:
        return None
    content = data[_SUM_BYTES:]
    return content if hashlib.sha256(content).digest() == data[:_SUM_BYTES] else None


def _forget(folder: Path) -> None:
    """Remove all but the entries that were used last, as far as they are proven to be ours."""
    used = []
    for path in folder.glob(f"*{_SUFFIX}"):
        # Others may remove it meanwhile.
        with suppress(OSError):
            used.append((path.lstat().st_mtime_ns, path))
    for _, path in sorted(used, reverse=True)[_MOST:]:
        if not path.is_symlink() and _content(path) is not None:
            with suppress(OSError):
                removal.remove_file(path)
