"""The one place where files are removed and renamed; a test forbids it elsewhere.

What may be removed is decided by others: `unfinished` knows what a process is still writing,
`ledger` what a command has written. Here nothing is ever followed through a link.
"""

import shutil
import sys
import time
from pathlib import Path
from typing import Final

# On Windows nothing is renamed while a virus scanner reads it, which takes moments.
_PAUSES_S: Final = (0.05, 0.1, 0.2, 0.4, 0.8)


def rename(source: Path, target: Path) -> None:
    """Give a file or folder its final name; a file of that name is replaced, a folder is not.

    Raises:
        OSError: It cannot be done.
    """
    for pause in _PAUSES_S if sys.platform == "win32" else ():
        try:
            source.replace(target)
            return
        except PermissionError:
            time.sleep(pause)
    source.replace(target)


def remove_file(path: Path) -> None:
    """Remove one file, or the link itself where it is one; nothing happens where there is none.

    Raises:
        OSError: It is a folder, or cannot be removed.
    """
    path.unlink(missing_ok=True)


def remove_if_empty(folder: Path) -> bool:
    """Remove a folder that holds nothing; whether it is gone.

    A link to a folder stays.
    """
    try:
        folder.rmdir()
    except FileNotFoundError:
        return True
    except OSError:
        return False
    return True


def remove_tree(folder: Path) -> None:
    """Remove a folder that this program made under a name of its own, with all that it holds.

    Links in it are removed, what they lead to is not. What cannot be removed stays.
    """
    if folder.is_symlink() or not folder.is_dir():
        return
    shutil.rmtree(folder, ignore_errors=True)


def copy_file(source: Path, target: Path) -> None:
    """Copy the bytes of a file to a new name.

    Raises:
        OSError: It cannot be done.
    """
    shutil.copyfile(source, target)


def real_parents(folder: Path, path: Path) -> bool:
    """Whether every folder between a folder and something in it is a real one, and no link."""
    between = [part for part in path.parents if part != folder and part.is_relative_to(folder)]
    return path.is_relative_to(folder) and not any(part.is_symlink() for part in between)
