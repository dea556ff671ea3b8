"""The contract of datasets: finished renders in the form of a published dataset.

A form is written of one render, of the variants of one room, or of all rooms at once: each says so.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, Protocol

from openrooms_usd import adapters
from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.portable import common_folder
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.reading import RenderedScene, read_render

Subset = Literal["train", "val", "test"]
Layout = Literal["split", "merged"]
Order = Literal["legacy", "rgb"]
Crowded = Literal["leave-out", "drop", "keep"]


@dataclass(frozen=True)
class DatasetOptions:
    """How to lay a dataset out; what has no meaning for a form stays as it is here.

    Attributes:
        scene: The scene's name in the dataset.
        splits: One for each render, in their order.
        subset: The list that the scene is added to: ``train``, ``val`` or ``test``.
        layout: ``split`` by channel, or ``merged``.
        order: In which order the channels of environment maps are stored.
        first: The number of the first view.
        crowded: What becomes of views with more lights than loaders have room for: they are left
            out, lose the least of their lights, or stay as they are.
        stages: The composed stage of each render, in their order: with them, what loaders of
            geometry read is written too. None need be given.
        taxonomy: Whose classes annotations have.
        shard_mb: How large a shard may become, megabytes; a single view may be larger.
        files: Which files of each view are taken, by name; all of channels where empty.
    """

    scene: str = "scene0000_00"
    splits: tuple[str, ...] = ("main_xml",)
    subset: Subset = "train"
    layout: Layout = "split"
    order: Order = "legacy"
    first: int = 1
    crowded: Crowded = "leave-out"
    stages: tuple[Path, ...] = ()
    taxonomy: str = "category"
    shard_mb: int = 256
    files: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class FinishedRoom:
    """A room with all that is finished of it.

    Attributes:
        name: What it is called.
        number: Its place among all rooms.
        split: What it is for.
        renders: By variant.
        rows: What the dataset's index says of views, by ``variant/view``; empty of single renders.
    """

    name: str
    number: int
    split: Subset
    renders: Mapping[str, RenderedScene]
    rows: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class DatasetSummary:
    """What was written.

    Attributes:
        root: The dataset's folder.
        frames: The numbers of the views, for each split.
        files: How many files.
        missing: By kind of file, why there is none of it.
        notes: What a user of the dataset should know of it.
    """

    root: Path
    frames: dict[str, list[int]]
    files: int
    missing: dict[str, str]
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The summary as plain data."""
        return {**asdict(self), "root": str(self.root), "notes": list(self.notes)}

    def __repr__(self) -> str:
        views = sum(map(len, self.frames.values()))
        missing = f"; missing: {', '.join(sorted(self.missing))}" if self.missing else ""
        return f"DatasetSummary({str(self.root)!r}: {self.files} files of {views} views{missing})"


class Form(Protocol):
    """What every form says of itself; an entry point ``openrooms_usd.datasets``."""

    takes: Literal["render", "variants", "rooms"]
    """What it is written of at once; the last is a `RoomsWriter`, others are `DatasetWriter`."""

    needs: Mapping[str, str]
    """The packages that it cannot do without, with the extra that brings each."""


class DatasetWriter(Form, Protocol):
    """Writes one render, or the variants of one room."""

    called: Mapping[str, str]
    """What it calls variants; where it has words for some, it is written of these alone."""

    def write(
        self,
        renders: Sequence[RenderedScene],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write a scene of a dataset; nothing appears before all is written.

        Args:
            renders: The variants of one scene.
            root: The dataset's folder; other scenes in it stay.
            options: How to lay it out.
            progress: Called with each finished view and the finished fraction.

        Raises:
            InputError: The renders or options do not fit each other.
            OutputError: A file cannot be written.
        """
        ...


class RoomsWriter(Form, Protocol):
    """Writes all rooms of a dataset."""

    def write_rooms(
        self,
        rooms: Iterable[FinishedRoom],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write all rooms; each is taken once, in order, and may be forgotten afterwards.

        Args:
            rooms: With all their variants.
            root: The folder of this form; what an earlier writing left there goes.
            options: How to lay it out.
            progress: Called with each room and a fraction.

        Raises:
            InputError: The rooms or options do not fit.
            OutputError: A file cannot be written.
        """
        ...


def check_needs(kind: str) -> None:
    """See that what a form needs is installed, before rooms are made for it.

    Raises:
        InputError: There is no such form.
        MissingPackageError: A package is missing.
    """
    writer: Form = adapters.load(adapters.DATASETS, kind)
    for package, extra in writer.needs.items():
        if find_spec(package) is None:
            raise MissingPackageError(
                f"the form {kind!r} needs {package}, which is not installed",
                remedy=f"pip install 'openrooms-usd[{extra}]'",
            )


def write_dataset(
    renders: Sequence[Path],
    root: Path,
    *,
    kind: str = "openrooms",
    options: DatasetOptions | None = None,
    progress: Progress = silent,
) -> DatasetSummary:
    """Write finished renders as the files of a published dataset.

    Args:
        renders: Folders of renders, the variants of one scene.
        root: The dataset's folder; other scenes in it stay.
        kind: Whose dataset.
        options: How to lay it out.
        progress: Called with each finished view and the finished fraction.

    Returns:
        What was written.

    Raises:
        InputError: There is no such dataset, or the renders or options do not fit each other.
        OutputError: A file cannot be written.
    """
    check_needs(kind)
    writer: Any = adapters.load(adapters.DATASETS, kind)
    wished = options or DatasetOptions()
    found: DatasetSummary
    if writer.takes == "rooms":
        found = writer.write_rooms(_rooms(renders, wished.subset), root, wished, progress)
    else:
        found = writer.write([read_render(one) for one in renders], root, wished, progress)
    return found


def _rooms(renders: Sequence[Path], subset: Subset) -> Iterator[FinishedRoom]:
    """Single renders as rooms with one variant each."""
    for number, (folder, name) in enumerate(zip(renders, _room_names(renders), strict=True)):
        yield FinishedRoom(name, number, subset, {"main": read_render(folder)})


def _room_names(renders: Sequence[Path]) -> list[str]:
    """Those of the folders; where two have the same, their paths below what they have in common."""
    paths = [folder.resolve() for folder in renders]
    if len(set(paths)) < len(paths):
        raise InputError("a render is given twice", place="renders", remedy="give each once")
    names = [folder.absolute().name for folder in renders]
    if len(set(names)) == len(names):
        return names
    common = common_folder(paths)
    return [path.relative_to(common).as_posix() for path in paths]
