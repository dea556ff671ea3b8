"""What a command has written into a folder: the proof that is needed to remove it again.

The ledger is a file of the folder, ``.orusd.sha256``, in the format of ``sha256sum``: a line has
the digest of a file and its path. A line is written before the file gets its name, so that also
what a killed process has left is known. A file is removed only where a line names it, where its
bytes are still those of the line, and where no link lies on the way. Nor does a file give way to
a new one without that proof.
"""

import errno
import hashlib
import os
import re
import stat
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Final

from openrooms_usd import removal, unfinished, untrusted
from openrooms_usd.errors import InputError, writing
from openrooms_usd.names import EDITS, LAYERS

FILE: Final = ".orusd.sha256"
# Renders keep one of their own: a room may lie in the same folder.
RENDER_FILE: Final = ".orusd.render.sha256"
# The layer of a room that people write as well: who replaces it has read it.
_PEOPLES: Final = f"{LAYERS}/{EDITS}.usda"

_LINE: Final = re.compile(r"(?P<digest>[0-9a-f]{64})  (?P<path>.+)")
# Files that differ from run to run are not recorded: they belong to the manifest beside them.
_TIMING: Final = re.compile(r"(?:(?P<of>[^/]+)_)?timing\.json")
# Of the name of an output, less than file systems allow by what is added here.
_LONGEST_BYTES: Final = 200
# Names with line ends would break the format: such files are never removed.
_UNWRITABLE: Final = re.compile(r"[\n\r\0\\]")


def name_of(output: str) -> str:
    """The name of the ledger of an output that shares its folder with others.

    Args:
        output: Its name, such as ``room.glb``; where it is too long, its digest stands for it.
    """
    data = os.fsencode(output)
    name = output if len(data) <= _LONGEST_BYTES else hashlib.sha256(data).hexdigest()[:16]
    return f".orusd.{name}.sha256"


def is_unwritable(name: str) -> bool:
    """Whether a name would break the format: such a file is never ours."""
    return bool(_UNWRITABLE.search(name))


class Ledger:
    """The ledger of one folder, while one process has the folder to itself.

    Args:
        folder: The folder; what lies below it is noted.
        file: The ledger's name in the folder.
        shared: Files that others write as well, relative to the folder.
        deep: Whether files in its subfolders are noted too.
    """

    def __init__(
        self,
        folder: Path,
        file: str = FILE,
        shared: Iterable[str] = (_PEOPLES,),
        *,
        deep: bool = True,
    ) -> None:
        self.folder = folder.absolute()
        self._shared, self._deep = frozenset(shared), deep
        self._file = self.folder / file
        self._digests: dict[str, set[str]] = {}
        self._by_us: dict[str, str] = {}
        self._created: set[str] = set()
        self._is_stale = False
        self._lock = threading.Lock()
        self._check_file()
        for path, digest in _read(self._file):
            self._digests.setdefault(path, set()).add(digest)

    def _check_file(self) -> None:
        """See that appending to the ledger changes nothing but the ledger."""
        if not os.path.lexists(self._file):
            return
        found = self._file.lstat()
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EEXIST, f"{self._file.name} is not a file that this tool wrote")
        if found.st_nlink > 1:
            # A copy by links, as backups make them, keeps its own.
            beside = unfinished.beside(self._file)
            removal.copy_file(self._file, beside)
            removal.rename(beside, self._file)

    def keeps(self, path: Path) -> bool:
        """Whether a file at an absolute path is one of those that are noted."""
        if not path.is_relative_to(self.folder):
            return False
        inner = path.relative_to(self.folder)
        return (self._deep or len(inner.parts) == 1) and not _is_passing(inner)

    def is_of(self, folder: Path, file: str) -> bool:
        """Whether this is the ledger of a folder under a name."""
        return self._file == folder.absolute() / file

    def note(self, source: Path, target: Path) -> None:
        """Note that a file, or all files of a folder, are about to get their final name.

        Args:
            source: Where the bytes lie now.
            target: Where they will lie.

        Raises:
            OSError: The bytes cannot be read, or the ledger cannot be written.
        """
        if source.is_dir() and not source.is_symlink():
            for inner in sorted(path for path in source.rglob("*") if path.is_file()):
                self._note(inner, target / inner.relative_to(source))
        else:
            self._note(source, target)

    def _note(self, source: Path, target: Path) -> None:
        name = self._name(target)
        if is_unwritable(name) or _TIMING.fullmatch(name):
            return
        with source.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        with self._lock:
            if not os.path.lexists(target):
                self._created.add(name)
            self._by_us[name] = digest
            if digest in self._digests.get(name, ()):
                return
            self._digests.setdefault(name, set()).add(digest)
            self._is_stale = True
            with self._file.open("a", encoding="utf-8", newline="\n") as lines:
                lines.write(f"{digest}  {name}\n")

    def below(self, folder: Path) -> list[Path]:
        """The files below a folder that were written once, sorted; some may be gone."""
        return self._below(folder, self._digests)

    def created_below(self, folder: Path) -> list[Path]:
        """The files below a folder that were not there before this process wrote them."""
        return self._below(folder, self._created)

    def _below(self, folder: Path, known: Iterable[str]) -> list[Path]:
        inside = self._name(folder)
        start = "" if inside == "." else f"{inside}/"
        return [self.folder / name for name in sorted(known) if name.startswith(start)]

    def is_own(self, path: Path) -> bool:
        """Whether a file is one that was written here, unchanged since, and behind no link."""
        path = path.absolute()
        known = self._digests.get(self._name(path))
        if not known or path.is_symlink() or not removal.real_parents(self.folder, path):
            return False
        return _digest(path) in known

    def may_replace(self, path: Path) -> bool:
        """Whether no user's work is lost if a new file replaces this one."""
        name = self._name(path)
        if not os.path.lexists(path) or name in self._shared:
            return True
        if found := _TIMING.fullmatch(name):
            return self.is_own(self.folder / f"{found['of'] or 'manifest'}.json")
        return self.is_own(path) or (path.is_file() and not path.lstat().st_size)

    def wrote(self, path: Path) -> bool:
        """Whether this very process wrote a file as it is now."""
        return self._by_us.get(self._name(path)) == _digest(path) != ""

    def remove(self, paths: Iterable[Path]) -> list[Path]:
        """Remove files that were written here, and the folders that are empty then.

        Args:
            paths: Files below the folder.

        Returns:
            Those that stay: changed files, foreign files, and files behind a link.

        Raises:
            OSError: A file cannot be removed.
        """
        stay = []
        for path in map(Path.absolute, paths):
            if self.is_own(path):
                removal.remove_file(path)
                self._is_stale = True
                self._remove_empty(path.parent)
            elif os.path.lexists(path):
                stay.append(path)
        return stay

    def _remove_empty(self, folder: Path) -> None:
        while folder != self.folder and not folder.is_symlink() and removal.remove_if_empty(folder):
            folder = folder.parent

    def tidy(self) -> None:
        """Let `close` write the ledger anew, also where nothing is noted or removed."""
        self._is_stale = True

    def close(self) -> None:
        """Write the lines of the files that are there, sorted; no file without any line.

        Nothing is written where nothing was noted or removed.
        """
        if not self._is_stale:
            return
        lines = [
            f"{digest}  {name}\n"
            for name in sorted(self._digests)
            if os.path.lexists(self.folder / name)
            for digest in sorted(self._latest(name))
        ]
        target = self._file
        data = "".join(lines).encode()
        if not lines:
            removal.remove_file(target)
        if not lines or _is_file_of(target, data):
            return
        beside = unfinished.beside(target)
        try:
            beside.write_bytes(data)
            removal.rename(beside, target)
        finally:
            removal.remove_file(beside)

    def _latest(self, name: str) -> set[str]:
        """The digest of a file that was written more than once; all of them where it is changed."""
        known = self._digests[name]
        found = known & {_digest(self.folder / name)} if len(known) > 1 else known
        return found or known

    def _name(self, path: Path) -> str:
        return path.absolute().relative_to(self.folder).as_posix()


def _is_file_of(path: Path, data: bytes) -> bool:
    try:
        return untrusted.read_bytes(path, "model") == data
    except InputError:
        return False


def _digest(path: Path) -> str:
    """SHA-256 of a file, hexadecimal; empty where it cannot be read."""
    try:
        with untrusted.opened(path, "frames") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except InputError:
        return ""


def _read(path: Path) -> list[tuple[str, str]]:
    """The lines of a ledger: paths within its folder and digests; other lines are ignored."""
    try:
        text = untrusted.read_text(path, "model") if os.path.lexists(path) else ""
    except InputError:
        return []
    found = (_LINE.fullmatch(line) for line in text.splitlines())
    rows = [(match["path"], match["digest"]) for match in found if match]
    return [(path, digest) for path, digest in rows if _is_inner(path)]


def _is_inner(path: str) -> bool:
    parts = PurePosixPath(path).parts
    return (
        bool(parts)
        and not is_unwritable(path)
        and not (path.startswith("/") or Path(path).drive)
        and ".." not in parts
        and not parts[-1].startswith(".orusd.")
    )


# Those of the folders that this process has to itself now, the innermost last.
_OPEN: Final[list[Ledger]] = []


def folders() -> list[Path]:
    """The folders of the ledgers that are open."""
    return [one.folder for one in _OPEN]


@contextmanager
def kept(
    folder: Path, file: str = FILE, shared: Iterable[str] = (_PEOPLES,), *, deep: bool = True
) -> Iterator[Ledger]:
    """Keep a ledger of what is written below a folder inside the block; blocks may be nested.

    Args:
        folder: A folder that no other process writes to (see `claims`).
        file: The ledger's name in the folder.
        shared: Files that others write as well, relative to the folder.
        deep: Whether files in its subfolders are noted too.

    Raises:
        OutputError: The ledger cannot be written.
    """
    known = next((one for one in _OPEN if one.is_of(folder, file)), None)
    if known:
        yield known
        return
    with writing(folder):
        ledger = Ledger(folder, file, shared, deep=deep)
        _OPEN.append(ledger)
        try:
            yield ledger
        finally:
            _OPEN.remove(ledger)
            ledger.close()


def note(source: Path, target: Path) -> None:
    """Note in the innermost open ledger that something is about to get its final name.

    Raises:
        OSError: The bytes cannot be read, or the ledger cannot be written.
    """
    if ledger := _keeping(target):
        ledger.note(source, target)


def may_replace(target: Path) -> bool:
    """Whether a file may give way to a new one, as far as the innermost open ledger knows."""
    ledger = _keeping(target)
    return ledger is None or ledger.may_replace(target)


def _keeping(target: Path) -> Ledger | None:
    """The innermost open ledger that a file is noted in."""
    target = target.absolute()
    return next((one for one in reversed(_OPEN) if one.keeps(target)), None)


def _is_passing(path: Path) -> bool:
    """Whether a path is unfinished, or in a cache: who writes there proves nothing."""
    is_cached = any(part.startswith(".orusd.") for part in path.parts[:-1])
    return is_cached or unfinished.is_unfinished(path)


def wrote(path: Path) -> bool:
    """Whether this very process wrote a file as it is now; what a ledger says may be forged."""
    path = path.absolute()
    return any(one.wrote(path) for one in _OPEN if path.is_relative_to(one.folder))


def foreign(folder: Path) -> list[str]:
    """What lies in a folder and is not known to be written by this program, or was changed since.

    Args:
        folder: Below one whose ledger is open, or anywhere.

    Returns:
        Paths in the folder, sorted; ``.`` where the folder itself is a link or a file.
    """
    folder = folder.absolute()
    if folder.is_symlink() or not folder.is_dir():
        return ["."]
    ledger = next((kept for kept in reversed(_OPEN) if folder.is_relative_to(kept.folder)), None)
    inner = sorted(path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir())
    return [
        path.relative_to(folder).as_posix()
        for path in inner
        if not (ledger and ledger.is_own(path))
    ]
