"""Names and paths as texts that say the same on Linux, macOS and Windows."""

import os
import shlex
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from openrooms_usd.errors import InputError

RESERVED: Final = frozenset(
    {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(1, 10))}
)
"""What Windows takes for devices, whatever the ending; in small letters."""


def relative_text(path: Path, start: Path) -> str:
    """How a folder leads to a file, with slashes; the whole path where that is on another drive."""
    try:
        return Path(os.path.relpath(path, start)).as_posix()
    except ValueError:
        return path.as_posix()


def anchored_text(path: Path, start: Path) -> str:
    """`relative_text` as a layer in the folder says it, from ``./`` or ``../`` on."""
    text = relative_text(path, start)
    return text if text.startswith("../") or Path(text).is_absolute() else f"./{text}"


def in_order(paths: Iterable[Path]) -> list[Path]:
    """Paths in one order on every system: those of Windows compare without case."""
    return sorted(paths, key=lambda path: path.parts)


def common_folder(paths: Sequence[Path | str]) -> Path:
    """The folder that all of some absolute paths lie in.

    Raises:
        InputError: They lie on several drives.
    """
    try:
        return Path(os.path.commonpath(paths))
    except ValueError:
        raise InputError(
            "these lie on different drives", place=paths[0], remedy="copy them to one drive"
        ) from None


def shell_line(words: Iterable[str]) -> str:
    """A command that can be pasted into the system's shell, whatever its paths are called."""
    if sys.platform != "win32":
        return shlex.join(words)
    from subprocess import list2cmdline

    return list2cmdline(words)
