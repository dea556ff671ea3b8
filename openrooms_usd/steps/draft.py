"""A composition in the making: its layers replace the old ones together, or not at all."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from pxr import Sdf

from openrooms_usd import atomic, claims, names, removal, unfinished
from openrooms_usd.errors import StageError, writing
from openrooms_usd.ledger import Ledger
from openrooms_usd.portable import in_order
from openrooms_usd.usd.files import layers as usd_layers


def changed(layer: Path) -> StageError:
    """Raised for a layer that was changed by hand and would be overwritten."""
    return StageError(
        "this layer was changed by hand, and composing would overwrite it",
        place=layer,
        remedy=f"move the change into {names.LAYERS}/{names.EDITS}.usda and remove this file",
    )


@dataclass
class Draft:
    """New layers that lie beside those that they will replace.

    Files that only one layer refers to are named by what determines them. So they are written
    where they belong at once, without touching those of the old layer.

    Attributes:
        out: The folder of the composition.
        ledger: What this program has written there.
        stay: What lies in the folders of new layers, is not referred to, and is not ours to remove.
    """

    out: Path
    ledger: Ledger
    stay: list[Path] = field(default_factory=list)
    _new: dict[Path, Path] = field(default_factory=dict)
    _kept: dict[str, frozenset[str]] = field(default_factory=dict)
    _folders: frozenset[Path] = frozenset()

    def __post_init__(self) -> None:
        self._folders = _folders(self.layers)

    @property
    def layers(self) -> Path:
        """The folder of the layers."""
        return self.out / names.LAYERS

    @property
    def scene(self) -> Path:
        """The root layer, where it will lie."""
        return self.out / names.SCENE

    def layer(self, name: str) -> Path:
        """Where a layer lies at the moment; it need not exist."""
        return self._new.get(self._place(name), self._place(name))

    def folder(self, name: str) -> Path:
        """Where the files of a step lie that only its layer refers to."""
        return self.layers / name

    @contextmanager
    def scratch(self, name: str) -> Iterator[Sdf.Layer]:
        """An empty layer in the folder of the layers: relative paths resolve in it."""
        path = unfinished.beside(self._place(name))
        try:
            with writing(self._place(name)):
                path.touch()
                layer = usd_layers.create(path)
            yield layer
        finally:
            with suppress(OSError):
                removal.remove_file(path)

    def export(self, layer: Sdf.Layer, name: str, kept: Iterable[str] = ()) -> None:
        """Draft a layer.

        Args:
            layer: What it holds.
            name: The step, or ``edits``.
            kept: What it refers to in the folder of its step; the rest will be removed.
        """
        self._draft(layer, self._place(name))
        # The folder of any other layer holds what people put into it.
        if name in names.STEPS:
            self.keep(name, kept)

    def check_unchanged(self, name: str) -> None:
        """Check that a layer that is about to be written was not changed by hand.

        Raises:
            StageError: It was, and writing it would lose the change.
        """
        if not self.ledger.may_replace(self._place(name)):
            raise changed(self._place(name))

    def keep(self, name: str, files: Iterable[str]) -> None:
        """Say what a layer refers to in the folder of its step; the rest of ours is removed.

        Args:
            name: The step.
            files: Files and folders, relative to the step's folder.
        """
        self._kept[name] = frozenset(files)

    def export_scene(self, layer: Sdf.Layer) -> None:
        """Draft the root layer."""
        self._draft(layer, self.scene)

    def commit(self) -> None:
        """Let the new layers take their places, and remove what nothing refers to any more."""
        with writing(self.out):
            for target, beside in self._new.items():
                atomic.rename_into_place(beside, target)
            for name, kept in self._kept.items():
                self._remove_others(name, kept)

    def discard(self) -> None:
        """Remove everything that is new."""
        for beside in self._new.values():
            removal.remove_file(beside)
        for name in names.STEPS:
            self.ledger.remove(self.ledger.created_below(self.folder(name)))
        # Workers that fail at the same time leave folders to each other.
        for folder in sorted(_folders(self.layers) - self._folders, reverse=True):
            removal.remove_if_empty(folder)

    def _remove_others(self, name: str, kept: frozenset[str]) -> None:
        """Remove what was written for earlier layers of a step, and see what else is there."""
        # As the ledger names its files.
        folder = self.folder(name).absolute()

        def is_kept(path: Path) -> bool:
            relative = path.relative_to(folder)
            return any(part.as_posix() in kept for part in (relative, *relative.parents))

        self.ledger.remove(path for path in self.ledger.below(folder) if not is_kept(path))
        if self._place(name) in self._new and folder.is_dir():
            inner = (path for path in in_order(folder.rglob("*")) if not path.is_dir())
            self.stay += [path for path in inner if not is_kept(path)]

    def _place(self, name: str) -> Path:
        return self.layers / f"{name}.usda"

    def _draft(self, layer: Sdf.Layer, target: Path) -> None:
        beside = unfinished.beside(target)
        # Known before it is there: an interruption may come in between.
        self._new[target] = beside
        with atomic.naming_target(target, beside):
            usd_layers.export(layer, beside)


def _folders(layers: Path) -> frozenset[Path]:
    """The folders of steps and those in them."""
    tops = [layers / name for name in names.STEPS if not (layers / name).is_symlink()]
    return frozenset(Path(inner) for top in tops for inner, _, _ in os.walk(top))


@contextmanager
def drafting(out: Path) -> Iterator[Draft]:
    """A draft that is committed when the block ends; when it raises, everything is as it was.

    Args:
        out: The folder of the composition; made when it is missing.

    Raises:
        OutputError: It cannot be written.
    """
    with claims.claimed(out) as ledger, atomic.making_folder(out / names.LAYERS):
        draft = Draft(out, ledger)
        try:
            yield draft
            draft.commit()
        except BaseException:
            # What cannot be removed now could not be written either.
            with suppress(OSError):
                draft.discard()
            raise
