"""Views as ``orusd render`` and ``orusd dataset run`` wrote them, here or behind a URL."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, Final

from openrooms_usd.errors import InputError
from openrooms_usd.loading.files import Files, LocalFiles
from openrooms_usd.loading.rendered import full_name, needed_files, sample_of
from openrooms_usd.loading.sample import Sample
from openrooms_usd.loading.source import ViewSelection, refuse_nothing
from openrooms_usd.names import natural_sort_key
from openrooms_usd.rendering.folder import MANIFEST
from openrooms_usd.rendering.manifest_schema import Manifest, read_manifest
from openrooms_usd.rendering.reading import RenderedView
from openrooms_usd.untrusted import is_plain_name, opened

INDEX: Final = "index.jsonl"
_FILE_KINDS: Final = (".exr", ".npy", ".npz")


@dataclass(frozen=True, slots=True)
class Row:
    """Where a view lies.

    Attributes:
        render: The folder of its render, below the root; empty: the root itself.
        view: Its name.
        about: ``room``, ``variant`` and ``split``.
        checksums: SHA-256 of its files by their paths in the render; empty if not needed.
    """

    render: str
    view: str
    about: Mapping[str, str]
    checksums: Mapping[str, str]

    @property
    def name(self) -> str:
        """What the view is called."""
        return full_name(self.view, self.about)


class RenderSource:
    """Views of finished renders.

    Args:
        files: Where they lie.
        rows: The views.
    """

    def __init__(self, files: Files, rows: Iterable[Row]) -> None:
        self.files = files
        self.rows = tuple(rows)

    def __len__(self) -> int:
        return len(self.rows)

    def read(self, index: int, channels: Sequence[str]) -> Sample:
        """One view; see `openrooms_usd.loading.source.Source`."""
        row = self.rows[index]
        manifest = _manifest(self.files, row.render)
        if row.view not in manifest.views:
            raise InputError("the manifest has no such view", place=f"{self.files}/{row.name}")
        entry = manifest.views[row.view]
        wanted = {
            _below(row.render, f): row.checksums.get(f, "") for f in needed_files(entry, channels)
        }
        with self.files.local(wanted) as root:
            view = RenderedView(row.view, root / row.render / row.view, entry)
            return sample_of(view, manifest, channels, row.about)


class RenderForm:
    """The folder of one render."""

    options: Mapping[str, str] = {}

    def open(
        self, files: Files, selection: ViewSelection, options: Mapping[str, str]
    ) -> RenderSource:
        """Its views; it has no variants, rooms and splits to choose by.

        Raises:
            InputError: It is not a finished render, or has no such view.
        """
        _manifest.cache_clear()
        views = sorted(_manifest(files, "").views, key=natural_sort_key)
        rows = [Row("", name, {}, {}) for name in views if selection.admits("", "", "", name)]
        refuse_nothing(len(rows), files, selection)
        return RenderSource(files, rows)


class DatasetForm:
    """The folder of a dataset, by its ``index.jsonl``."""

    options: Mapping[str, str] = {}

    def open(
        self, files: Files, selection: ViewSelection, options: Mapping[str, str]
    ) -> RenderSource:
        """Its views that are wanted, in the order of the index.

        Raises:
            InputError: There is no sound index, or no such view.
        """
        _manifest.cache_clear()
        with files.local({INDEX: ""}) as root:
            rows = [
                row
                for row in _rows(root / INDEX, files)
                if selection.admits(
                    row.about["split"], row.about["variant"], row.about["room"], row.view
                )
            ]
        refuse_nothing(len(rows), files, selection)
        return RenderSource(files, rows)


def _rows(index: Path, files: Files) -> Iterator[Row]:
    """The lines of an index, one by one: of a million views it has gigabytes."""
    keeps = not isinstance(files, LocalFiles)
    with opened(index, "frames", remedy="finish it: orusd dataset run") as stream:
        for number, line in enumerate(stream, 1):
            try:
                yield _row(json.loads(line), keeps)
            except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
                place = f"{files}/{INDEX}:{number}"
                raise InputError(f"this is not a line of an index: {error}", place=place) from error


def _row(found: Any, keeps_checksums: bool) -> Row:
    folder = PurePosixPath(found["folder"])
    about = {key: str(found[key]) for key in ("room", "variant", "split")}
    if folder.is_absolute() or not all(map(is_plain_name, folder.parts)) or not folder.name:
        raise ValueError(f"{str(folder)!r} leads elsewhere")
    kept = {
        str(name): str(sha)
        for name, sha in found["files"].items()
        if keeps_checksums and PurePosixPath(name).suffix in _FILE_KINDS
    }
    return Row(folder.parent.as_posix(), folder.name, about, kept)


@lru_cache(maxsize=256)
def _manifest(files: Files, render: str) -> Manifest:
    """The manifest of a render; a process keeps a few, until it opens something anew."""
    with files.local({_below(render, MANIFEST): ""}) as root:
        return read_manifest(root / render)


def _below(render: str, file: str) -> str:
    return f"{render}/{file}" if render not in ("", ".") else file
