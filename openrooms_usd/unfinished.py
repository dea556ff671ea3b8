"""Names of what is being written: beside its target, and told apart from everybody else's files.

``scene.usda`` is written as ``.scene.orusd-1234-5f0c9e-0.usda``: the process, when it began, and a
number that it uses once. A process that is killed leaves such files behind. Who next has the folder
to itself (see `claims`) sweeps them away, provided that their process is gone.
"""

import hashlib
import itertools
import os
import re
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

from openrooms_usd import processes, removal

_NUMBERS: Final = itertools.count()
# In a container every process may have the same number.
_BEGAN: Final = f"{time.time_ns():x}"
_NAME: Final = re.compile(
    r"\.(?P<stem>.*)\.orusd-(?P<pid>\d{1,10})-(?P<began>[0-9a-f]+)-\d+(?P<suffix>(?:\.[^.]*)?)"
)
# A folder that makes room for a new one of its name.
_OLD: Final = ".old"
# The longest name of a file, less what is added here.
_LONGEST_STEM_BYTES: Final = 200


def beside(target: Path) -> Path:
    """A free name beside a file or folder to be; it keeps the suffix, which tells the format."""
    return target.with_name(_marked(target.stem, target.suffix))


def parking_name(target: Path) -> Path:
    """A free name for the folder that a new one replaces; swept back where the new never came."""
    return target.with_name(_marked(target.name, _OLD))


def is_unfinished(path: Path) -> bool:
    """Whether a path leads to, or through, something that was being written."""
    return any(_NAME.fullmatch(part) for part in path.parts)


def leftovers(folder: Path, *, own: bool = False) -> Iterator[Path]:
    """What processes that are gone left in a folder, itself and no deeper.

    Args:
        folder: The folder.
        own: Whether this process counts as gone.
    """
    # A folder that cannot be read has nothing to sweep: the next writer there will report it.
    with suppress(OSError):
        for entry in sorted(folder.iterdir()):
            found = _NAME.fullmatch(entry.name)
            if found and (
                (own and _is_this(found)) or not _is_running(int(found["pid"]), found["began"])
            ):
                yield entry


def sweep(folder: Path, *, own: bool = False) -> None:
    """Remove what processes that are gone left in a folder, itself and no deeper.

    An earlier folder that had just made room for a new one, which never came, is put back.

    Args:
        folder: One that no other process of this program writes to now.
        own: Whether this process is as good as gone, too.
    """
    for path in list(leftovers(folder, own=own)):
        found = _NAME.fullmatch(path.name)
        with suppress(OSError):
            before = path.with_name(found["stem"]) if found else path
            if found and found["suffix"] == _OLD and not os.path.lexists(before):
                removal.rename(path, before)
            elif path.is_dir() and not path.is_symlink():
                removal.remove_tree(path)
            else:
                removal.remove_file(path)


def _marked(stem: str, suffix: str) -> str:
    if len(os.fsencode(stem)) > _LONGEST_STEM_BYTES:
        stem = hashlib.sha256(os.fsencode(stem)).hexdigest()[:16]
    return f".{stem}.orusd-{os.getpid()}-{_BEGAN}-{next(_NUMBERS)}{suffix}"


def _is_this(found: re.Match[str]) -> bool:
    return int(found["pid"]) == os.getpid() and found["began"] == _BEGAN


def _is_running(pid: int, began: str) -> bool:
    """Whether a process may still be writing; true if unknown."""
    if pid == os.getpid():
        return began == _BEGAN
    return processes.is_running(pid)
