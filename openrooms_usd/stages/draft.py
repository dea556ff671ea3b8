"""A composition in the making: its layers replace the old ones together, or not at all."""

import itertools
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from pxr import Sdf

from openrooms_usd import atomic, names
from openrooms_usd.errors import writing
from openrooms_usd.usd import layers as usd_layers

_NUMBERS: Final = itertools.count()


@dataclass
class Draft:
    """New layers that lie beside those that they will replace.

    Files that only one layer refers to are named by what determines them. So they are written
    where they belong at once, without touching those of the old layer.

    Attributes:
        out: The folder of the composition.
    """

    out: Path
    _new: dict[Path, Path] = field(default_factory=dict)
    _before: dict[str, set[str]] = field(default_factory=dict)
    _kept: dict[str, set[str]] = field(default_factory=dict)

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

    def begin(self, name: str) -> Path:
        """Note what the folder of a stage's files holds, and return the folder."""
        folder = self.layers / name
        self._before[name] = {
            path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()
        }
        return folder

    @contextmanager
    def scratch(self, name: str) -> Iterator[Sdf.Layer]:
        """An empty layer in the folder of the layers: relative paths resolve in it."""
        path = self._beside(self._place(name))
        try:
            with writing(self._place(name)):
                path.touch()
                layer = usd_layers.create(path)
            yield layer
        finally:
            with suppress(OSError):
                path.unlink()

    def export(self, layer: Sdf.Layer, name: str, kept: Iterable[str] = ()) -> None:
        """Draft a layer.

        Args:
            layer: What it holds.
            name: The stage, or ``edits``.
            kept: What it refers to in the folder of its stage; the rest will be removed.
        """
        self._draft(layer, self._place(name))
        # The folder of any other layer holds what people put into it.
        if name in names.STAGES:
            self._kept[name] = set(kept)

    def export_scene(self, layer: Sdf.Layer) -> None:
        """Draft the root layer."""
        self._draft(layer, self.scene)

    def commit(self) -> None:
        """Let the new layers take their places, and remove what nothing refers to any more."""
        with writing(self.out):
            for target, beside in self._new.items():
                beside.replace(target)
            for name, kept in self._kept.items():
                _remove_others(self.layers / name, kept)

    def discard(self) -> None:
        """Remove everything that is new."""
        for beside in self._new.values():
            beside.unlink(missing_ok=True)
        for name, before in self._before.items():
            _remove_others(self.layers / name, before)

    def _place(self, name: str) -> Path:
        return self.layers / f"{name}.usda"

    def _beside(self, target: Path) -> Path:
        # Numbered, because USD refuses to make a layer while an old one of its name is held.
        return target.with_name(f".{target.stem}.{os.getpid()}.{next(_NUMBERS)}{target.suffix}")

    def _draft(self, layer: Sdf.Layer, target: Path) -> None:
        beside = self._beside(target)
        # Known before it is there: an interruption may come in between.
        self._new[target] = beside
        with atomic.naming(target, beside):
            usd_layers.export(layer, beside)


@contextmanager
def drafting(out: Path) -> Iterator[Draft]:
    """A draft that is committed when the block ends; when it raises, everything is as it was.

    Args:
        out: The folder of the composition; made when it is missing.

    Raises:
        OutputError: It cannot be written.
    """
    draft = Draft(out)
    with atomic.making(draft.layers):
        try:
            yield draft
            draft.commit()
        except BaseException:
            # What cannot be removed now could not be written either.
            with suppress(OSError):
                draft.discard()
            raise


def _remove_others(folder: Path, kept: set[str]) -> None:
    """Remove what is in a stage's folder and is not kept, nor in a folder that is."""
    if not folder.is_dir():
        return
    for path in sorted(folder.rglob("*"), reverse=True):
        relative = path.relative_to(folder)
        if any(parent.as_posix() in kept for parent in (relative, *relative.parents)):
            continue
        if path.is_file():
            path.unlink()
        elif not any(path.iterdir()):
            path.rmdir()
    if not any(folder.iterdir()):
        folder.rmdir()
