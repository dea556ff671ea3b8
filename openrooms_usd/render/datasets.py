"""The contract of datasets: finished renders in the form of somebody else's dataset."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

from openrooms_usd import adapters
from openrooms_usd.progress import Progress, silent
from openrooms_usd.render.reading import RenderedScene, read_render

Subset = Literal["train", "val", "test"]
Layout = Literal["split", "merged"]
Order = Literal["legacy", "rgb"]
Crowded = Literal["leave-out", "drop", "keep"]


@dataclass(frozen=True)
class DatasetOptions:
    """How to lay a dataset out.

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
    """

    scene: str = "scene0000_00"
    splits: tuple[str, ...] = ("main_xml",)
    subset: Subset = "train"
    layout: Layout = "split"
    order: Order = "legacy"
    first: int = 1
    crowded: Crowded = "leave-out"
    stages: tuple[Path, ...] = ()


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


class DatasetWriter(Protocol):
    """Writes renders as a dataset; an entry point ``openrooms_usd.datasets``."""

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
    writer: DatasetWriter = adapters.load(adapters.DATASETS, kind)
    opened = [read_render(folder) for folder in renders]
    return writer.write(opened, root, options or DatasetOptions(), progress)
