"""All views of a dataset as shards, which are read from end to end."""

import io
import json
import os
import re
import tarfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any, Final

from openrooms_usd import atomic, claims, untrusted
from openrooms_usd.errors import InputError, writing
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.datasets import DatasetOptions, DatasetSummary, FinishedRoom
from openrooms_usd.rendering.folder import load_manifest
from openrooms_usd.rendering.reading import RenderedView
from openrooms_usd.untrusted import is_plain_name

BLOCK: Final = 512
_MODE: Final = 0o644
INDEX: Final = "shards.json"
_LEDGER: Final = ".orusd.webdataset.sha256"
_MEGABYTE: Final = 1_000_000
# An archive ends with two empty blocks, in a record of twenty.
_END: Final = 20 * BLOCK
_KINDS: Final = (".exr", ".npy")
_NUMBER: Final = re.compile(r"view_([0-9]{1,9})")
# What a manifest says of all views, not of one.
_SHARED: Final = ("views", "report")


@dataclass(frozen=True)
class Sample:
    """A view on its way into a shard.

    Attributes:
        key: What the names of its files begin with; ordered as the views are.
        files: By what comes after the key and a dot.
        text: Its JSON.
    """

    key: str
    files: Mapping[str, Path]
    text: str

    @property
    def sizes(self) -> list[int]:
        """Bytes of its files."""
        return [*(path.stat().st_size for path in self.files.values()), len(self.text.encode())]


def samples(room: FinishedRoom, wanted: Sequence[str]) -> Iterator[Sample]:
    """The samples of a room, ordered by their keys.

    Args:
        room: The room.
        wanted: Which files of each view, by name; all of channels where empty.

    Raises:
        InputError: A render is damaged, or no view has such a file.
    """
    for variant, render in sorted(room.renders.items()):
        said = load_manifest(render.folder)[1]
        shared = {name: value for name, value in said.items() if name not in _SHARED}
        numbers = dict(zip(_numbers([*render.views]), render.views.values(), strict=True))
        for number, view in sorted(numbers.items()):
            about = {
                "room": room.name,
                "split": room.split,
                "variant": variant,
                "view": view.name,
                **{what: said["views"][view.name][what] for what in _CAMERA},
                "entry": said["views"][view.name],
                "render": shared,
            }
            key = f"{room.number:07d}-{variant}-{number:04d}"
            yield Sample(key, _files(view, wanted), json.dumps(about, sort_keys=True, indent=1))


_CAMERA: Final = ("K", "world_from_camera", "resolution")


def _numbers(names: Sequence[str]) -> list[int]:
    """Of views: those in their names where each has its own there, else their places."""
    found = [int(said[1]) for name in names if (said := _NUMBER.fullmatch(name))]
    return found if len(set(found)) == len(names) else [*range(len(names))]


def _files(view: RenderedView, wanted: Sequence[str]) -> dict[str, Path]:
    """The files of a view that are in its folder, by name; in folders with dots."""
    if wanted:
        found = {name.replace("/", "."): view.folder / PurePosixPath(name) for name in wanted}
        for name in wanted:
            path = view.folder / PurePosixPath(name)
            if not all(map(is_plain_name, name.split("/"))) or not os.path.lexists(path):
                raise InputError(
                    f"the view has no file {name!r}",
                    place=view.folder,
                    remedy=f"it has: {', '.join(sorted(_existing_files(view)))}",
                )
        return dict(sorted(found.items()))
    return {
        name: view.folder / name for name in sorted(_existing_files(view)) if name.endswith(_KINDS)
    }


def _existing_files(view: RenderedView) -> set[str]:
    """The names of the files that the manifest names and that are there."""
    paths: list[Any] = [PurePosixPath(path) for path in view.entry.paths()]
    names = {path.relative_to(view.name).as_posix() for path in paths}
    return {name for name in names if os.path.lexists(view.folder / name) and "/" not in name}


class WebDataset:
    """Shards of each split, and ``shards.json``, which lists them (docs/howto/webdataset.md)."""

    takes: Final = "rooms"
    needs: Mapping[str, str] = MappingProxyType({})

    def write_rooms(
        self,
        rooms: Iterable[FinishedRoom],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write ``train/train-000000.tar`` and so on; see `rendering.datasets.RoomsWriter`.

        Of the options it knows ``shard_mb`` and ``files``.
        """
        with claims.refilling(root, _LEDGER) as refill:
            with ExitStack() as opened:
                shards = _Shards(refill.folder, options.shard_mb * _MEGABYTE, opened)
                for room in rooms:
                    progress(room.name, 0.5)
                    for sample in samples(room, options.files):
                        shards.of(room.split).add(sample)
            listed = shards.listed
            text = json.dumps(listed, indent=1, sort_keys=True)
            atomic.write_text(refill.folder / INDEX, f"{text}\n")
        counts = {
            split: list(range(sum(row["samples"] for row in rows)))
            for split, rows in listed.items()
        }
        return DatasetSummary(root, counts, len(refill.written), {})


class _Shards:
    """The shards of all splits, one of each being written."""

    def __init__(self, root: Path, most: int, opened: ExitStack) -> None:
        self._root, self._most, self._opened = root, most, opened
        self._splits: dict[str, _Split] = {}

    def of(self, split: str) -> "_Split":
        """The shards of one split."""
        if split not in self._splits:
            self._splits[split] = self._opened.enter_context(_Split(self._root, split, self._most))
        return self._splits[split]

    @property
    def listed(self) -> dict[str, list[dict[str, Any]]]:
        """Of each split the finished shards: ``file``, how many ``samples``, and ``bytes``."""
        return {
            name: [row | {"bytes": (self._root / row["file"]).stat().st_size} for row in split.rows]
            for name, split in sorted(self._splits.items())
        }


class _Split(ExitStack):
    """The shards of one split; a new one begins where the next view would make one too large."""

    def __init__(self, root: Path, name: str, most: int) -> None:
        super().__init__()
        self.rows: list[dict[str, Any]] = []
        self._root, self._name, self._most = root, name, most
        self._size = 0
        self._now: Archive | None = None

    def add(self, sample: Sample) -> None:
        """Add a view."""
        size = sum(map(room_for, sample.sizes))
        if self._now is None or self._size + size + _END > self._most:
            self._begin()
        assert self._now is not None
        for name in sorted([*sample.files, "json"]):
            if name == "json":
                self._now.add_text(f"{sample.key}.json", sample.text)
            else:
                self._now.add_file(f"{sample.key}.{name}", sample.files[name])
        self._size += size
        self.rows[-1]["samples"] += 1

    def _begin(self) -> None:
        # What was written so far appears.
        self.close()
        file = f"{self._name}/{self._name}-{len(self.rows):06d}.tar"
        self.rows.append({"file": file, "samples": 0})
        self._now, self._size = self.enter_context(archive(self._root / file)), 0


class Archive:
    """A tar file that is being written.

    Args:
        file: Where it goes.
    """

    def __init__(self, file: tarfile.TarFile) -> None:
        self._file = file

    def add_text(self, name: str, text: str) -> None:
        """Add a file of text."""
        data = text.encode()
        self._file.addfile(_header(name, len(data)), io.BytesIO(data))

    def add_file(self, name: str, path: Path) -> None:
        """Add a copy of a file.

        Raises:
            InputError: It cannot be read.
        """
        with untrusted.opened(path, "frames", remedy="render again") as stream:
            self._file.addfile(_header(name, path.stat().st_size), stream)


@contextmanager
def archive(path: Path) -> Iterator[Archive]:
    """A tar file that appears whole, or not at all.

    Raises:
        OutputError: It cannot be written.
    """
    with (
        atomic.replacing(path) as beside,
        writing(path),
        # Long names get a header of their own, without a time.
        tarfile.open(beside, "w", format=tarfile.PAX_FORMAT) as file,
    ):
        yield Archive(file)


def room_for(size: int) -> int:
    """The bytes that a file of a size takes in an archive, with its header."""
    return BLOCK + -(-size // BLOCK) * BLOCK


def _header(name: str, size: int) -> tarfile.TarInfo:
    # Its time, owner and group are 0 already.
    header = tarfile.TarInfo(name)
    header.size, header.mode = size, _MODE
    return header
