"""The files of a dataset, here or elsewhere, as local files for as long as they are read.

Elsewhere is any URL that fsspec knows: ``s3://``, ``http://``, ``memory://``. What was fetched is
kept in a cache of bounded size, by its checksum, and shared by processes: each locks what it reads,
and who fetches something new removes what was not read for longest.
"""

import hashlib
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final, Protocol

from openrooms_usd import atomic, removal, unfinished, urls, usercache
from openrooms_usd.errors import InputError, writing
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.untrusted import inside, is_plain_name, opened

if TYPE_CHECKING:
    from filelock import BaseFileLock

MOST_CACHED: Final = 20 << 30
"""Bytes that a cache holds unless told otherwise."""

# What breaks off on its way is asked for again.
_TRIES: Final = 3
_PAUSE_S: Final = 0.5
_LOCKS: Final = "locks"
# A download that was begun so long ago goes on no more.
_ABANDONED_S: Final = 86_400.0


class Files(Protocol):
    """The files below a folder or a URL; it can be pickled, and be a key."""

    def __hash__(self) -> int:
        """Equal for equal roots."""
        ...

    @contextmanager
    def local(self, wanted: Mapping[str, str]) -> Iterator[Path]:
        """A folder in which some files are, as they lie below the root.

        Args:
            wanted: Their checksums (SHA-256) by their paths, with forward slashes; no checksum is
                the empty text.

        Raises:
            InputError: A file cannot be fetched.
        """
        ...

    def names(self, folder: str) -> list[str]:
        """What is in a folder below the root, sorted; nothing where there is none."""
        ...


@dataclass(frozen=True)
class LocalFiles:
    """A folder of this machine.

    Attributes:
        root: The folder.
    """

    root: Path

    def __str__(self) -> str:
        return str(self.root)

    @contextmanager
    def local(self, wanted: Mapping[str, str]) -> Iterator[Path]:
        """The folder itself; the reader reports what is missing."""
        yield self.root

    def names(self, folder: str) -> list[str]:
        """What is in a folder."""
        path = self.root / folder
        return sorted(inner.name for inner in path.iterdir()) if path.is_dir() else []


@dataclass(frozen=True)
class RemoteFiles:
    """What lies below a URL.

    Attributes:
        url: The URL.
        cache: Where fetched files are kept; None: they are not.
        most: Bytes that the cache holds at most, besides what is being read.
    """

    url: str
    cache: Path | None
    most: int = MOST_CACHED

    def __str__(self) -> str:
        return urls.shown(self.url)

    @contextmanager
    def local(self, wanted: Mapping[str, str]) -> Iterator[Path]:
        """A folder of the cache; files without a checksum are fetched each time.

        Raises:
            InputError: A file cannot be fetched, or is not the one that its checksum says.
            MissingPackageError: fsspec, or what it needs for this URL, is not installed.
            OutputError: The cache cannot be written.
        """
        if self.cache is None or not all(wanted.values()):
            with scratch_folder() as folder:
                self._fetch(wanted, folder)
                yield folder
            return
        told = "\n".join((self.url, *(f"{name} {sha}" for name, sha in sorted(wanted.items()))))
        kept = self.cache / hashlib.sha256(told.encode()).hexdigest()
        with writing(self.cache):
            held = _lock(kept).acquire()
        with held:
            with writing(self.cache):
                self._keep(kept, wanted)
            yield kept

    def names(self, folder: str) -> list[str]:
        """What is in a folder, as far as the server tells.

        Raises:
            InputError: It cannot be asked.
        """
        system, root = urls.file_system(self.url)
        found: list[str] = []
        with suppress(urls.MissingFileError), urls.reading(f"{self.url}/{folder}"):
            found = system.ls(f"{root}/{folder}".rstrip("/"), detail=False)
        names = (PurePosixPath(str(path).rstrip("/")).name for path in found)
        return sorted({name for name in names if is_plain_name(name)})

    def _keep(self, kept: Path, wanted: Mapping[str, str]) -> None:
        """See that something is in the cache, and the last to leave it."""
        if not kept.is_dir():
            with atomic.replacing_folder(kept) as beside:
                self._fetch(wanted, beside)
            _remove_oldest(kept, self.most)
        # Finer than the clock that a file system keeps times by.
        now = time.time_ns()
        os.utime(kept, ns=(now, now))

    def _fetch(self, wanted: Mapping[str, str], folder: Path) -> None:
        system, root = urls.file_system(self.url)
        for name, sha in wanted.items():
            target = inside(folder, name)
            target.parent.mkdir(parents=True, exist_ok=True)
            _download(system, f"{root}/{name}", target, f"{self.url}/{name}")
            if sha and _digest(target) != sha:
                raise InputError(
                    "its checksum differs from the one in the index",
                    place=f"{self}/{name}",
                    remedy="the dataset was changed or is damaged: orusd dataset verify",
                )


def files_of(
    root: str | os.PathLike[str], cache: Path | None = None, most: int = MOST_CACHED
) -> Files:
    """The files below a folder or a URL.

    Args:
        root: A folder, or a URL with ``://``.
        cache: Where fetched files are kept; by default the user's cache.
        most: Bytes that the cache holds at most.
    """
    text = os.fspath(root)
    if not urls.is_url(text):
        return LocalFiles(Path(text))
    return RemoteFiles(text.rstrip("/"), cache or usercache.cache_folder("views"), most)


def _digest(path: Path) -> str:
    with opened(path, "frames") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _download(system: Any, source: str, target: Path, url: str) -> None:
    for left in reversed(range(_TRIES)):
        try:
            with urls.reading(url):
                system.get_file(source, str(target))
            return
        except urls.MissingFileError:
            raise
        except InputError:
            if not left:
                raise
            time.sleep(_PAUSE_S)


def _lock(kept: Path) -> "BaseFileLock":
    """The lock of something in the cache; a few are shared by all."""
    from filelock import FileLock

    folder = kept.parent / _LOCKS
    folder.mkdir(parents=True, exist_ok=True)
    return FileLock(folder / f"{kept.name[:2]}.lock")


def _remove_oldest(newest: Path, most: int) -> None:
    """Remove what was not read for longest until the rest fits; what is being read stays."""
    from filelock import Timeout

    found = [path for path in newest.parent.iterdir() if _is_kept(path)]
    sizes = {path: _bytes(path) for path in found}
    left = sum(sizes.values())
    for path in sorted(found, key=_when):
        if left <= most:
            return
        if path == newest:
            continue
        # Some have the lock that is held already.
        is_held = path.name[:2] == newest.name[:2]
        try:
            with nullcontext() if is_held else _lock(path).acquire(blocking=False):
                removal.remove_tree(path)
        except Timeout:
            continue
        left -= sizes[path]


def _is_kept(path: Path) -> bool:
    """Whether something in the cache is there to be read, not just being fetched."""
    if unfinished.is_unfinished(Path(path.name)):
        return _when(path) < time.time_ns() - _ABANDONED_S * 1e9
    return path.is_dir() and path.name != _LOCKS


def _bytes(folder: Path) -> int:
    """How large a folder is; what others remove meanwhile has no size."""
    size = 0
    for home, _, names in os.walk(folder):
        for path in (Path(home, name) for name in names):
            with suppress(FileNotFoundError):
                size += path.stat().st_size
    return size


def _when(path: Path) -> int:
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return 0
