"""One writer a folder: a command locks the folder that it writes to, and sweeps it first.

The lock is the operating system's (``flock``), which goes with its process: a lock file of a killed
process blocks no other process. The file says who holds the lock, for the message.
"""

import os
import re
import stat
import sys
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from openrooms_usd import atomic, ledger, removal, unfinished, untrusted
from openrooms_usd.errors import InputError, OutputError, writing
from openrooms_usd.names import LAYERS

if TYPE_CHECKING:
    from filelock import BaseFileLock

FILE: Final = ".orusd.lock"

_LONGEST_HOLDER: Final = 120  # characters
# What stands in a lock file; nothing where its process was killed before it said who it is.
_HOLDER: Final = re.compile(r"(?:process \d+ \(|\Z)")
# What this process holds: folders, each with the thread that claimed it.
_HELD: Final[set[tuple[Path, int]]] = set()
# Those of them that were not there before.
_MADE: Final[set[Path]] = set()


@contextmanager
def claimed(folder: Path, file: str = ledger.FILE, **how: Any) -> Iterator[ledger.Ledger]:
    """Have a folder to oneself, with a ledger of what is written to it.

    What killed processes have left there is swept. A claim within a claim of the same folder is
    the same claim.

    Args:
        folder: The folder; it is made when it is missing, and goes again when the block raises and
            it is empty.
        file: The name of the ledger in it.
        how: What else `ledger.kept` takes.

    Yields:
        The folder's ledger.

    Raises:
        OutputError: Another process writes to the folder, or it cannot be written.
    """
    with locked(folder) as was_killed, ledger.kept(folder, file, **how) as kept:
        if was_killed:
            kept.tidy()
        yield kept


@dataclass
class Refill:
    """The files of a folder that are written anew.

    Attributes:
        folder: Where they are written.
        written: Where they lie at the end, absolute paths.
        stay: Files of an earlier run that are obsolete now, but were changed by hand.
    """

    folder: Path
    written: frozenset[Path] = frozenset()
    stay: Sequence[Path] = ()


@contextmanager
def refilling(folder: Path, file: str) -> Iterator[Refill]:
    """Write all files of a folder, as `atomic.replacing_files`; those of an earlier run give way.

    Args:
        folder: The folder; what is not noted in the ledger stays.
        file: The name of the ledger in it.

    Raises:
        OutputError: Another process writes to the folder, it cannot be written, or a file that is
            not ours would give way.
    """
    with claimed(folder, file) as kept:
        with atomic.replacing_files(folder) as beside:
            refill = Refill(beside)
            yield refill
            inner = [path.relative_to(beside) for path in beside.rglob("*") if path.is_file()]
        refill.written = frozenset(folder.absolute() / path for path in inner)
        with writing(folder):
            refill.stay = kept.remove(p for p in kept.below(folder) if p not in refill.written)


def check_refill(folder: Path, file: str, names: Iterable[str]) -> None:
    """See before long work that `refilling` may write files, and folders that are ours alone.

    Args:
        folder: The folder.
        file: The name of the ledger in it.
        names: What will be written, relative to the folder.

    Raises:
        OutputError: Something that is not ours would give way.
    """
    with ledger.kept(folder, file):
        atomic.check_free(folder / name for name in names)


@contextmanager
def output(target: Path) -> Iterator[None]:
    """Write a single file that a person named inside the block; see `check_output`.

    Others may write other files into its folder at the same time.

    Raises:
        OutputError: It cannot be written, or is there and not ours.
    """
    with (
        atomic.making_folder(target.parent),
        ledger.kept(target.parent, _ledger_of(target), deep=False),
    ):
        yield


def check_output(target: Path) -> None:
    """See before long work that `output` may write a file.

    Raises:
        OutputError: The existing file is not as an earlier run wrote it, or is not a file.
    """
    atomic.check_replaceable(target)
    with ledger.kept(target.parent, _ledger_of(target), deep=False):
        atomic.check_free([target])


def _ledger_of(target: Path) -> str:
    if ledger.is_unwritable(target.name):
        raise OutputError(
            "the name has a backslash or a line end, so the ledger cannot record it",
            place=target,
            remedy="choose another output",
        )
    return ledger.name_of(target.name)


@contextmanager
def locked(folder: Path) -> Iterator[bool]:
    """Have a folder to oneself, and swept, without a ledger.

    Yields:
        Whether the process that had it last was killed.
    """
    key = (folder.absolute(), threading.get_ident())
    if key in _HELD:
        yield False
        return
    with writing(folder):
        is_new = not folder.exists()
    with atomic.making_folder(folder), _exclusively(folder) as was_killed:
        _HELD.add(key)
        if is_new:
            _MADE.add(key[0])
        try:
            for inner in _to_sweep(folder) if was_killed else [folder]:
                unfinished.sweep(inner)
            yield was_killed
        finally:
            _HELD.remove(key)
            _MADE.discard(key[0])


def abandon() -> None:
    """Leave all folders that this process holds as if it had been interrupted.

    For a process that is about to end while its main thread cannot be stopped: what it has not
    finished is removed, and so are its lock files.
    """
    for folder, _ in list(_HELD):
        for inner in list(_to_sweep(folder)):
            unfinished.sweep(inner, own=True)
        with suppress(OSError):
            removal.remove_file(folder / FILE)
        if folder in _MADE:
            removal.remove_if_empty(folder)
    for folder in ledger.folders():
        unfinished.sweep(folder, own=True)


def _to_sweep(folder: Path) -> Iterator[Path]:
    """A folder, and all folders of a room's layers in it: nowhere else is written in place."""
    yield folder
    layers = folder / LAYERS
    if not layers.is_symlink():
        yield from (Path(name) for name, _, _ in os.walk(layers))


@contextmanager
def _exclusively(folder: Path) -> Iterator[bool]:
    """Hold the lock of a folder; whether the process that had it last was killed."""
    from filelock import FileLock, Timeout

    path = folder / FILE
    was_killed = os.path.lexists(path)
    _check_lock(path)
    lock = FileLock(path, timeout=0)
    with writing(folder):
        try:
            lock.acquire()
        except Timeout:
            raise _held_by(path, folder) from None
        except NotADirectoryError as error:
            raise OSError(error.errno, "this is not a folder") from error
    try:
        with suppress(OSError):
            path.write_text(f"process {os.getpid()} ({_command()})\n", encoding="utf-8")
        yield was_killed
    finally:
        _release(lock, path)


def _check_lock(path: Path) -> None:
    """Refuse to lock by a file that is not a lock file: its text would be replaced."""
    # Others come and go meanwhile, and their files with them.
    if os.path.lexists(path) and not any(_is_lock(path) for _ in range(3)):
        raise OutputError(
            "this is not a lock file of this tool", place=path, remedy="remove it, or move it away"
        )


def _is_lock(path: Path) -> bool:
    """Whether a file was left or is held by `_exclusively`; also true if it is missing."""
    try:
        found = path.lstat()
        if not stat.S_ISREG(found.st_mode) or found.st_nlink > 1:
            return False
        return _HOLDER.match(untrusted.read_text(path)) is not None
    except (OSError, InputError) as error:
        # Windows refuses to read a locked file.
        return isinstance(error.__cause__, PermissionError) or not os.path.lexists(path)


def _release(lock: "BaseFileLock", path: Path) -> None:
    # While it is held: who waits for the old file sees that it is gone, and makes a new one.
    if sys.platform != "win32":
        with suppress(OSError):
            removal.remove_file(path)
    lock.release()
    if sys.platform == "win32":
        with suppress(OSError):
            removal.remove_file(path)


def _held_by(path: Path, folder: Path) -> OutputError:
    try:
        holder = untrusted.read_text(path).partition("\n")[0][:_LONGEST_HOLDER]
    except InputError:
        holder = ""
    return OutputError(
        f"{holder or 'another process'} is writing into this folder",
        place=folder,
        remedy="wait until it has ended, or choose another output folder",
    )


def _command() -> str:
    """What a person typed, without paths: ``orusd render``."""
    words = [word for word in sys.argv[1:2] if word.isalpha()]
    return " ".join([Path(sys.argv[0]).name or "python", *words])
