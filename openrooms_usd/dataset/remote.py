"""Files of a dataset behind a URL: each comes whole or not at all, and in the order they are put.

Any URL of fsspec will do, such as ``s3://bucket/name`` (`openrooms_usd.urls`).
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final, TypeVar

from openrooms_usd import atomic, urls
from openrooms_usd.errors import OutputError
from openrooms_usd.untrusted import inside

# Files that are asked for at once: so many answers are kept in memory.
_BATCH: Final = 256

Item = TypeVar("Item")


class RemoteFolder:
    """What lies below a URL.

    Args:
        url: The URL; names of files are relative to it, with forward slashes.

    Raises:
        InputError: It is not a supported URL.
        MissingPackageError: fsspec, or what it needs for such URLs, is not installed.
    """

    def __init__(self, url: str) -> None:
        self.url = url.rstrip("/")
        self._system, self._root = urls.file_system(self.url)

    def put(self, folder: Path, names: Iterable[str]) -> None:
        """Put files of a folder there; which of them comes first is open.

        Raises:
            OutputError: It cannot be done.
        """
        for batch in _batches(names):
            with self._writing():
                self._system.put([str(folder / name) for name in batch], self._paths(batch))

    def put_text(self, name: str, text: str, *, new: bool = False) -> bool:
        """Put a file there.

        Args:
            name: Its name.
            text: What it says.
            new: Whether it must not be there yet. Where the server knows no such condition
                (``If-None-Match``), it is looked for before.

        Returns:
            Whether it could be put: one that must be new may be there.

        Raises:
            OutputError: It cannot be done.
        """
        path, data = f"{self._root}/{name}", text.encode()
        with self._writing():
            if not new:
                self._system.pipe_file(path, data)
                return True
            if self._system.exists(path):
                return False
            try:
                self._system.pipe_file(path, data, mode="create")
            except FileExistsError:
                return False
            except OSError as error:
                # So s3fs tells of a precondition that failed.
                if "PreconditionFailed" not in str(error) and "pre-conditions" not in str(error):
                    raise
                return False
        return True

    def read(self, name: str) -> bytes | None:
        """A whole file; None where there is none.

        Raises:
            InputError: It cannot be read.
        """
        found: bytes | None = None
        with suppress(urls.MissingFileError), urls.reading(f"{self.url}/{name}"):
            found = self._system.cat_file(f"{self._root}/{name}")
        return found

    def get(self, names: Iterable[str], folder: Path) -> None:
        """Bring small files into a folder; those that are not there are left out.

        Raises:
            InputError: One cannot be read.
            OutputError: The folder cannot be written.
        """
        for batch in _batches(names):
            with urls.reading(self.url):
                found = self._system.cat(self._paths(batch), on_error="return")
            for name, path in zip(batch, self._paths(batch), strict=True):
                data = found[path]
                if isinstance(data, bytes):
                    atomic.write_bytes(inside(folder, name), data)
                elif not isinstance(data, FileNotFoundError):
                    raise urls.unreadable(f"{self.url}/{name}", data) from data

    def get_all(self, prefix: str, folder: Path) -> None:
        """Bring all that lies below a name into a folder.

        Raises:
            InputError: One cannot be read.
        """
        for batch in _batches(self.names(prefix)):
            targets = [inside(folder, name) for name in batch]
            for target in targets:
                target.parent.mkdir(parents=True, exist_ok=True)
            with urls.reading(f"{self.url}/{prefix}"):
                self._system.get(self._paths(batch), [str(target) for target in targets])

    def names(self, prefix: str) -> list[str]:
        """The names of all files below a name.

        Raises:
            InputError: They cannot be listed.
        """
        found: list[str] = []
        with suppress(urls.MissingFileError), urls.reading(f"{self.url}/{prefix}"):
            found = self._system.find(f"{self._root}/{prefix}")
        return sorted(path.removeprefix(f"{self._root}/") for path in found)

    def folders(self, prefix: str) -> set[str]:
        """The names right below a name; none where nothing is there.

        Raises:
            InputError: They cannot be listed.
        """
        found: list[str] = []
        with suppress(urls.MissingFileError), urls.reading(f"{self.url}/{prefix}"):
            found = self._system.ls(f"{self._root}/{prefix}", detail=False)
        return {path.rstrip("/").rpartition("/")[2] for path in found}

    def remove(self, names: Iterable[str]) -> None:
        """Remove files; those that are not there are left out.

        Raises:
            OutputError: One cannot be removed.
        """
        for path in self._paths(list(names)):
            with self._writing(), suppress(FileNotFoundError):
                self._system.rm_file(path)

    def _paths(self, names: list[str]) -> list[str]:
        return [f"{self._root}/{name}" for name in names]

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except Exception as error:
            is_missing = isinstance(error, FileNotFoundError)
            raise OutputError(
                f"cannot write: {urls.shown(error)}",
                place=urls.shown(self.url),
                remedy="create the bucket first"
                if is_missing
                else "check the URL and your permission to write",
            ) from error


def _batches(items: Iterable[Item]) -> Iterator[list[Item]]:
    batch: list[Item] = []
    for item in items:
        batch.append(item)
        if len(batch) == _BATCH:
            yield batch
            batch = []
    if batch:
        yield batch
