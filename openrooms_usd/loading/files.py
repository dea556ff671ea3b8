"""The files of a dataset, here or elsewhere, as local files for as long as they are read.

Elsewhere is any URL that fsspec knows: ``s3://``, ``http://``, ``memory://``. What was fetched is
kept in a cache of bounded size, by its checksum, and shared by processes: each locks what it reads,
and who fetches something new removes what was not read for longest.
"""

import hashlib
import os
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final, Protocol

from openrooms_usd import atomic, removal, usercache
from openrooms_usd.errors import InputError, MissingPackageError, writing
from openrooms_usd.untrusted import inside, is_plain_name

if TYPE_CHECKING:
    from filelock import BaseFileLock

MOST_CACHED: Final = 20 << 30
"""Bytes that a cache holds unless told otherwise."""

_TRIES: Final = 3
_LOCKS: Final = "locks"


class MissingFileError(InputError):
    """Nothing is behind a path of a URL."""


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
        """The folder itself; whoever reads says what is missing."""
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
        return self.url

    @contextmanager
    def local(self, wanted: Mapping[str, str]) -> Iterator[Path]:
        """A folder of the cache; files without a checksum are fetched each time.

        Raises:
            InputError: A file cannot be fetched, or is not the one that its checksum says.
            MissingPackageError: fsspec, or what it needs for this URL, is not installed.
            OutputError: The cache cannot be written.
        """
        if self.cache is None or not all(wanted.values()):
            with tempfile.TemporaryDirectory() as folder:
                self._fetch(wanted, Path(folder))
                yield Path(folder)
            return
        told = "\n".join((self.url, *(f"{name} {sha}" for name, sha in sorted(wanted.items()))))
        kept = self.cache / hashlib.sha256(told.encode()).hexdigest()
        with writing(self.cache):
            lock = _lock(kept)
        with lock:
            with writing(self.cache):
                self._keep(kept, wanted)
            yield kept

    def names(self, folder: str) -> list[str]:
        """What is in a folder, as far as the server tells.

        Raises:
            InputError: It cannot be asked.
        """
        system, root = _system(self.url, os.getpid())
        try:
            found = system.ls(f"{root.rstrip('/')}/{folder}".rstrip("/"), detail=False)
        except FileNotFoundError:
            return []
        # What stands behind a URL raises what it likes.
        except Exception as error:
            raise InputError(f"cannot list it: {error}", place=f"{self.url}/{folder}") from error
        names = (PurePosixPath(str(path).rstrip("/")).name for path in found)
        return sorted({name for name in names if is_plain_name(name)})

    def _keep(self, kept: Path, wanted: Mapping[str, str]) -> None:
        """See that something is in the cache, and the last to leave it."""
        if not kept.is_dir():
            with atomic.appearing(kept) as beside:
                self._fetch(wanted, beside)
            _remove_oldest(kept, self.most)
        # Finer than the clock that a file system keeps times by.
        now = time.time_ns()
        os.utime(kept, ns=(now, now))

    def _fetch(self, wanted: Mapping[str, str], folder: Path) -> None:
        system, root = _system(self.url, os.getpid())
        for name, sha in wanted.items():
            target = inside(folder, name)
            target.parent.mkdir(parents=True, exist_ok=True)
            _download(system, f"{root.rstrip('/')}/{name}", target, f"{self.url}/{name}")
            if sha and hashlib.sha256(target.read_bytes()).hexdigest() != sha:
                raise InputError(
                    "its checksum is not the one that the index says",
                    place=f"{self.url}/{name}",
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
    if "://" not in text:
        return LocalFiles(Path(text))
    return RemoteFiles(text.rstrip("/"), cache or usercache.cache_folder("views"), most)


@lru_cache(maxsize=8)
def _system(url: str, process: int) -> tuple[Any, str]:
    """The file system of a URL, one for each process: connections do not survive a fork."""
    try:
        import fsspec
    except ImportError as error:
        raise MissingPackageError(
            f"{url} needs the package 'fsspec'", remedy="pip install 'openrooms-usd[remote]'"
        ) from error
    try:
        system, root = fsspec.core.url_to_fs(url, skip_instance_cache=not url.startswith("memory"))
    except ImportError as error:
        raise MissingPackageError(str(error), remedy="install what it names") from error
    except ValueError as error:
        raise InputError(f"no URL that can be read: {error}", place=url) from error
    return system, root


def _download(system: Any, source: str, target: Path, place: str) -> None:
    for left in reversed(range(_TRIES)):
        try:
            system.get_file(source, str(target))
            return
        except FileNotFoundError as error:
            raise MissingFileError("no such file", place=place, remedy="check the URL") from error
        # What stands behind a URL raises what it likes.
        except Exception as error:
            if not left:
                raise InputError(f"cannot fetch it: {error}", place=place) from error
            time.sleep(0.5)


def _lock(kept: Path) -> "BaseFileLock":
    """The lock of something in the cache; a few are shared by all."""
    from filelock import FileLock

    folder = kept.parent / _LOCKS
    folder.mkdir(parents=True, exist_ok=True)
    return FileLock(folder / f"{kept.name[:2]}.lock")


def _remove_oldest(newest: Path, most: int) -> None:
    """Remove what was not read for longest until the rest fits; what is being read stays."""
    from filelock import Timeout

    found = [path for path in newest.parent.iterdir() if path.is_dir() and path.name != _LOCKS]
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


def _bytes(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def _when(path: Path) -> int:
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return 0
