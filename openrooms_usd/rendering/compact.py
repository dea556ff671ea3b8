"""Channels of views in compact storage, by name: read, or worked out, when they are asked for."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from openrooms_usd.channels import definition
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.exr import Pixels, read_channels
from openrooms_usd.rendering.manifest_schema import (
    AGAIN,
    ChannelEntry,
    DenoisedEntry,
    StoredEntry,
    ViewEntry,
)
from openrooms_usd.rendering.restoring import restored, sources_of


def is_compact(entry: ViewEntry) -> bool:
    """Whether a view says of its channels how they are stored."""
    return any(row.stored for row in entry.channels.values())


def unscaled(pixels: Pixels, row: ChannelEntry | DenoisedEntry | None) -> Pixels:
    """A channel as it was before it was stored.

    Args:
        pixels: (height, width, components) as the file has it.
        row: What the manifest says of the channel.
    """
    if row is None or row.stored is None or row.stored.scale == 1.0:
        return pixels
    return np.asarray(pixels / np.float32(row.stored.scale), np.float32)


class CompactChannels(Mapping[str, Pixels]):
    """The channels of one scope: (height, width, components) by name.

    Args:
        folder: Of the view.
        entry: What the manifest says of it.
        scope: ``view`` or ``light``.
    """

    def __init__(self, folder: Path, entry: ViewEntry, scope: str) -> None:
        self._folder, self._entry = folder, entry
        self._names = [name for name in entry.channels if _scope(name) == scope]
        self._files: dict[str, dict[str, Pixels]] = {}
        self._worked_out: dict[str, Pixels] = {}

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __getitem__(self, name: str) -> Pixels:
        if name not in self._names:
            raise KeyError(name)
        way = self._entry.channels[name].stored
        if way is not None and way.file:
            return self._read(name, way)
        if name not in self._worked_out:
            self._worked_out[name] = self._restored(name)
        return self._worked_out[name]

    def _read(self, name: str, way: StoredEntry) -> Pixels:
        assert way.file is not None
        path = self._folder.parent / way.file
        if way.file not in self._files:
            layers = read_channels(path, self._entry.resolution)
            rows = self._entry.channels
            self._files[way.file] = {one: unscaled(layers[one], rows.get(one)) for one in layers}
        try:
            return self._files[way.file][name]
        except KeyError:
            raise InputError(f"it has no channel {name!r}", place=path, remedy=AGAIN) from None

    def _restored(self, name: str) -> Pixels:
        sources = sources_of(name)
        if not sources or not {*sources} <= {*self._names}:
            raise InputError(
                f"the manifest lists no file with the channel {name!r}",
                place=self._folder,
                remedy=AGAIN,
            )
        parts = {source: self[source] for source in sources}
        pose = np.array(self._entry.world_from_camera, np.float64)
        return restored(name, parts, np.array(self._entry.K, np.float64), pose)


class Numbered(Mapping[int, Pixels]):
    """Channels by numbers, each read when it is asked for.

    Args:
        channels: By name.
        names: Of some of them, by number.
    """

    def __init__(self, channels: Mapping[str, Pixels], names: Mapping[int, str]) -> None:
        self._channels, self._names = channels, names

    def __iter__(self) -> Iterator[int]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __getitem__(self, number: int) -> Pixels:
        return self._channels[self._names[number]]


def _scope(name: str) -> str:
    try:
        return definition(name).scope
    except KeyError:  # another tool's
        return ""
