"""WebDataset shards of views: tar files that are read from end to end, here or behind a URL.

``shards.json`` lists them by split. In a shard the files of a view follow each other; their names
are its key, a dot and what each is, and ``KEY.json`` says what the manifest says of the view.
"""

import json
import os
import tarfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import IO, Any, Final

from pydantic import ValidationError

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.loading.files import Files
from openrooms_usd.loading.rendered import needed_files, sample_of
from openrooms_usd.loading.sample import Sample
from openrooms_usd.loading.source import ViewSelection, refuse_nothing
from openrooms_usd.rendering.manifest_schema import Manifest
from openrooms_usd.rendering.reading import RenderedView
from openrooms_usd.scratch import scratch_folder

INDEX: Final = "shards.json"
_MOST_BYTES: Final = untrusted.MOST_BYTES["picture"]


@dataclass(frozen=True)
class TarShards:
    """Shards of some splits.

    Attributes:
        files: Where they lie.
        counts: How many views each holds, by its path below the root.
        selection: Which of these are wanted.
    """

    files: Files
    counts: Mapping[str, int]
    selection: ViewSelection

    @property
    def names(self) -> tuple[str, ...]:
        """Their paths below the root."""
        return tuple(self.counts)

    def __len__(self) -> int:
        return sum(self.counts.values())

    def stream(self, name: str, channels: Sequence[str]) -> Iterator[Sample]:
        """The views of a shard; see `openrooms_usd.loading.source.Shards`."""
        place, found = f"{self.files}/{name}", 0
        with self.files.local({name: ""}) as root, untrusted.opened(root / name, "frames") as raw:
            for key, parts in _views(raw, place):
                found += 1
                sample = self._sample(key, parts, channels, f"{place}:{key}")
                if sample is not None:
                    yield sample
        # One that ends too early between two files looks whole to tar.
        if found != self.counts[name]:
            raise InputError(
                f"it holds {found} views, but {INDEX} says {self.counts[name]}",
                place=place,
                remedy="copy it again, or write the shards again",
            )

    def _sample(
        self, key: str, parts: Mapping[str, bytes], channels: Sequence[str], place: str
    ) -> Sample | None:
        """A view of its files, by what comes after the key and a dot."""
        try:
            said = json.loads(parts["json"])
            view = str(said["view"])
            about = {what: str(said[what]) for what in ("room", "variant", "split")}
            whole = {**said["render"], "views": {view: said["entry"]}}
            manifest = Manifest.model_validate_json(json.dumps(whole))
        except (KeyError, TypeError, ValueError, RecursionError, ValidationError) as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(f"not a view of a dataset: {reason}", place=place) from error
        if not self.selection.admits(about["split"], about["variant"], about["room"], view):
            return None
        entry = manifest.views[view]
        with scratch_folder() as folder:
            for path in needed_files(entry, channels):
                target = untrusted.inside(folder, path)
                target.parent.mkdir(exist_ok=True)
                # The folder of the view is the key here; folders in it are dots.
                inner = path.partition("/")[2].replace("/", ".")
                if inner in parts:
                    target.write_bytes(parts[inner])
            rendered = RenderedView(view, folder / view, entry)
            return sample_of(rendered, manifest, channels, about)


def _views(stream: IO[bytes], place: str) -> Iterator[tuple[str, dict[str, bytes]]]:
    """The keys of a shard, each with its files."""
    key, parts = "", dict[str, bytes]()
    try:
        with tarfile.open(fileobj=stream, mode="r:") as archive:
            for member in archive:
                found, dot, what = member.name.partition(".")
                if not member.isfile() or not dot or not untrusted.is_plain_name(member.name):
                    raise InputError(f"{member.name[:60]!r} is not a file of a view", place=place)
                if member.size > _MOST_BYTES:
                    raise InputError(f"{member.name!r} has {member.size:,} bytes", place=place)
                if found != key and parts:
                    yield key, parts
                    parts = {}
                key, inner = found, archive.extractfile(member)
                assert inner is not None
                parts[what] = inner.read()
    # The last one: a header that says of itself that another follows, without end.
    except (tarfile.TarError, EOFError, RecursionError) as error:
        raise InputError(f"a damaged shard: {error}", place=place) from error
    if parts:
        yield key, parts


class ShardsForm:
    """The folder of ``orusd dataset``'s WebDataset shards."""

    options: Mapping[str, str] = {}

    def open(self, files: Files, selection: ViewSelection, options: Mapping[str, str]) -> TarShards:
        """The shards of the splits that are wanted.

        Raises:
            InputError: There is no sound list of them, or they hold no view.
        """
        with files.local({INDEX: ""}) as root:
            text = untrusted.read_text(root / INDEX, "json")
        try:
            counts = {
                _path(row["file"]): int(row["samples"])
                for split, rows in json.loads(text).items()
                if not selection.splits or split in selection.splits
                for row in rows
            }
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            place = f"{files}/{INDEX}"
            raise InputError(f"this is not a list of shards: {error}", place=place) from error
        found = TarShards(files, counts, selection)
        refuse_nothing(len(found), files, selection)
        return found


def _path(given: Any) -> str:
    path = os.fspath(given)
    if not path or not all(map(untrusted.is_plain_name, path.split("/"))):
        raise ValueError(f"{path!r} leads elsewhere")
    return str(path)
