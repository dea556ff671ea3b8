"""Views as ``orusd render`` and ``orusd dataset run`` wrote them, here or behind a URL."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import CHANNELS, definition
from openrooms_usd.errors import InputError
from openrooms_usd.loading.files import Files, LocalFiles
from openrooms_usd.loading.sample import Sample, is_label
from openrooms_usd.loading.source import Selection, refuse_nothing
from openrooms_usd.names import in_order
from openrooms_usd.render.compact import is_compact
from openrooms_usd.render.folder import MANIFEST
from openrooms_usd.render.manifest_schema import Manifest, StoredEntry, ViewEntry, read_manifest
from openrooms_usd.render.reading import RenderedView
from openrooms_usd.untrusted import is_plain_name, read_text

INDEX: Final = "index.jsonl"
_FILE_KINDS: Final = (".exr", ".npy", ".npz")
_REMEDY: Final = "ask for channels that are there, or render it with them"


@dataclass(frozen=True, slots=True)
class Row:
    """Where a view lies.

    Attributes:
        render: The folder of its render, below the root; empty: the root itself.
        view: Its name.
        about: ``room``, ``variant`` and ``split``.
        checksums: SHA-256 of its files by their paths in the render; empty where nobody needs them.
    """

    render: str
    view: str
    about: Mapping[str, str]
    checksums: Mapping[str, str]

    @property
    def name(self) -> str:
        """What the view is called."""
        known = (self.about.get("room"), self.about.get("variant"), self.view)
        return "/".join(word for word in known if word)


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
            return sample_of(view, manifest, channels, row)


class RenderForm:
    """The folder of one render."""

    options: Mapping[str, str] = {}

    def open(self, files: Files, selection: Selection, options: Mapping[str, str]) -> RenderSource:
        """Its views; variants, rooms and splits are not known.

        Raises:
            InputError: It is no finished render, or has no such view.
        """
        wanted = Selection(views=selection.views)
        views = sorted(_manifest(files, "").views, key=in_order)
        rows = [Row("", name, {}, {}) for name in views if wanted.admits("", "", "", name)]
        refuse_nothing(len(rows), files, wanted)
        return RenderSource(files, rows)


class DatasetForm:
    """The folder of a dataset, by its ``index.jsonl``."""

    options: Mapping[str, str] = {}

    def open(self, files: Files, selection: Selection, options: Mapping[str, str]) -> RenderSource:
        """Its views that are wanted, in the order of the index.

        Raises:
            InputError: There is no sound index, or no such view.
        """
        with files.local({INDEX: ""}) as root:
            text = read_text(root / INDEX, "annotations", remedy="finish it: orusd dataset run")
        keeps = not isinstance(files, LocalFiles)
        rows = []
        for number, line in enumerate(text.splitlines(), 1):
            try:
                row = _row(json.loads(line), keeps)
            except (ValueError, KeyError, TypeError, AttributeError) as error:
                place = f"{files}/{INDEX}:{number}"
                raise InputError(f"this is no line of an index: {error}", place=place) from error
            about = row.about
            if selection.admits(about["split"], about["variant"], about["room"], row.view):
                rows.append(row)
        refuse_nothing(len(rows), files, selection)
        return RenderSource(files, rows)


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
    """The manifest of a render; a process keeps a few."""
    with files.local({_below(render, MANIFEST): ""}) as root:
        return read_manifest(root / render)


def _below(render: str, file: str) -> str:
    return f"{render}/{file}" if render not in ("", ".") else file


def needed_files(entry: ViewEntry, channels: Sequence[str]) -> set[str]:
    """The files that channels are made of, by what the manifest says.

    Args:
        entry: Of the view.
        channels: Names of the table.

    Returns:
        Paths in the folder of the render.

    Raises:
        InputError: There is no such channel.
    """
    if not is_compact(entry):
        grids = {name for name in channels if _scope(name) == "grid"}
        lights = any(_scope(name) == "light" for name in channels)
        kinds = {"channels", *grids, *(["lights"] if lights else [])}
        return {path for kind, path in (entry.files or {}).items() if kind in kinds}
    known: dict[str, StoredEntry | None] = {}
    waiting = {name for name in entry.channels if _is_of(name, channels)}
    while waiting:
        known |= {name: entry.channels[name].stored for name in waiting & {*entry.channels}}
        sources = {source for row in known.values() if row for source in row.sources}
        waiting = (sources - {*known}) & {*entry.channels}
    return {row.file for row in known.values() if row and row.file}


def _is_of(name: str, channels: Sequence[str]) -> bool:
    """Whether a single image, such as ``direct_3``, is of one of some channels."""
    try:
        return definition(name).name in channels
    except KeyError:  # somebody else's
        return False


def _scope(name: str) -> str:
    if name not in CHANNELS:
        raise InputError(
            f"there is no channel {name!r}", remedy="'orusd channels' lists them by their names"
        )
    return CHANNELS[name].scope


def sample_of(view: RenderedView, manifest: Manifest, channels: Sequence[str], row: Row) -> Sample:
    """A view as a sample.

    Args:
        view: As it was rendered.
        manifest: Of its render.
        channels: Names of the table.
        row: What it is called, and what is known of it.

    Raises:
        InputError: A channel is missing, or a file is damaged.
    """
    by_scope = {scope: [n for n in channels if _scope(n) == scope] for scope in ("light", "grid")}
    images = {n: _image(view, n) for n in channels if CHANNELS[n].scope == "view"}
    numbers = _numbers(view, by_scope["light"])
    boxes = {light.number: light for light in manifest.lights}
    known = [boxes[number] for number in numbers if number in boxes]
    if len(known) < len(numbers):
        raise InputError("the manifest does not know all its lights", place=view.folder)
    return Sample(
        name=row.name,
        size=(view.width, view.height),
        K=view.K,
        world_from_camera=view.world_from_camera,
        images=images,
        lights={
            n: np.stack([view.lights[n.removesuffix("_i")][number] for number in numbers])
            for n in by_scope["light"]
        },
        grids={n: _grid(view, n) for n in by_scope["grid"]},
        light_numbers=tuple(numbers),
        world_from_box=np.array([row.world_from_box for row in known]).reshape(-1, 4, 4),
        box_size=np.array([row.size for row in known]).reshape(-1, 3),
        about=row.about,
    )


def _image(view: RenderedView, name: str) -> NDArray[Any]:
    if name not in view.pixels:
        raise _missing(view.folder, name)
    if is_label(CHANNELS[name]):
        return view.labels(name)[..., None]
    return view.pixels[name]


def _grid(view: RenderedView, name: str) -> NDArray[np.float32]:
    found = view.grid(name)
    if found is None:
        raise _missing(view.folder, name)
    return found


def _numbers(view: RenderedView, channels: Sequence[str]) -> list[int]:
    """The numbers of the lights that channels have, which all have the same."""
    found: list[list[int]] = []
    for name in channels:
        if name.removesuffix("_i") not in view.lights:
            raise _missing(view.folder, name)
        found.append(sorted(view.lights[name.removesuffix("_i")]))
    if any(numbers != found[0] for numbers in found):
        raise InputError("its channels of lights have not the same lights", place=view.folder)
    return found[0] if found else []


def _missing(folder: Path, channel: str) -> InputError:
    return InputError(f"it has no channel {channel!r}", place=folder, remedy=_REMEDY)
