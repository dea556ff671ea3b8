"""A view as a sample: a key, its files, and one JSON file with all that is known of it."""

import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, Final

from openrooms_usd.errors import InputError
from openrooms_usd.render.datasets import FinishedRoom
from openrooms_usd.render.folder import load_manifest
from openrooms_usd.render.reading import RenderedView
from openrooms_usd.untrusted import is_plain_name

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
                    remedy=f"it has: {', '.join(sorted(_known(view)))}",
                )
        return dict(sorted(found.items()))
    return {name: view.folder / name for name in sorted(_known(view)) if name.endswith(_KINDS)}


def _known(view: RenderedView) -> set[str]:
    """The names of the files that the manifest names and that are there."""
    paths: list[Any] = [PurePosixPath(path) for path in view.entry.paths()]
    names = {path.relative_to(view.name).as_posix() for path in paths}
    return {name for name in names if os.path.lexists(view.folder / name) and "/" not in name}
