"""All views of a dataset as shards, which are read from end to end."""

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from openrooms_usd import atomic
from openrooms_usd.progress import Progress, silent
from openrooms_usd.render.datasets import (
    DatasetOptions,
    DatasetSummary,
    FinishedRoom,
    replacing_all,
)
from orusd_webdataset.archive import BLOCK, Archive, archive, room_for
from orusd_webdataset.sample import Sample, samples

INDEX: Final = "shards.json"
_LEDGER: Final = ".orusd.webdataset.sha256"
_MEGABYTE: Final = 1_000_000
# An archive ends with two empty blocks, in a record of twenty.
_END: Final = 20 * BLOCK


class WebDataset:
    """Shards of each split, and ``shards.json``, which lists them (docs/webdataset.md)."""

    takes: Final = "rooms"
    needs: Mapping[str, str] = MappingProxyType({})

    def write_rooms(
        self,
        rooms: Iterable[FinishedRoom],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write ``train/train-000000.tar`` and so on; see `render.datasets.RoomsWriter`.

        Of the options it knows ``shard_mb`` and ``files``.
        """
        with replacing_all(root, _LEDGER) as written:
            with ExitStack() as opened:
                shards = _Shards(root, options.shard_mb * _MEGABYTE, opened)
                for room in rooms:
                    progress(room.name, 0.5)
                    for sample in samples(room, options.files):
                        shards.of(room.split).add(sample)
            listed = shards.listed
            atomic.write_text(root / INDEX, json.dumps(listed, indent=1, sort_keys=True) + "\n")
            written |= {root.absolute() / name for name in (*_names(listed), INDEX)}
        counts = {split: list(range(sum(row["samples"] for row in rows)))
                  for split, rows in listed.items()}  # fmt: skip
        return DatasetSummary(root, counts, len(written), {})


def _names(listed: Mapping[str, list[dict[str, Any]]]) -> Iterator[str]:
    return (row["file"] for rows in listed.values() for row in rows)


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
