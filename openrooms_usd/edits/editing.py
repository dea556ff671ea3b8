"""People's changes made in Python: the composed stage, open such that they go to the edits."""

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Final

from pxr import Sdf, Usd

from openrooms_usd import atomic, claims, names, untrusted
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.steps import runner
from openrooms_usd.steps.draft import drafting
from openrooms_usd.usd.files.layers import open_stage

_EDITS: Final = f"{names.LAYERS}/{names.EDITS}.usda"

# The stages that this thread is editing, by their scene.
_EDITING: Final[ContextVar[Mapping[Path, Usd.Stage]]] = ContextVar(
    "editing", default=MappingProxyType({})
)


@contextmanager
def editing(scene: Path) -> Iterator[Usd.Stage]:
    """Open a composed room such that all that is authored goes to ``layers/edits.usda``.

    The layer is saved when the block ends, and is as before when the block or the saving fails.
    Inside of such a block, another one of the same room is a part of it: both are saved together.

    Args:
        scene: The ``scene.usda`` of a composed room.

    Yields:
        The composed stage; its edit target is the layer.

    Raises:
        InputError: It is not a composed room.
        StageError: With what was authored the room would not compose, or the scene is not as
            compose wrote it.
        OutputError: The layer cannot be written.
    """
    if (outer := being_edited(scene)) is not None:
        yield outer
        return
    _check_composed(scene)
    with claims.claimed(scene.parent):
        stage = open_stage(scene)
        layer = _edits(stage, scene)
        stage.SetEditTarget(Usd.EditTarget(layer))
        before = _EDITING.set({**_EDITING.get(), scene.resolve(): stage})
        try:
            yield stage
            if layer.dirty:
                with drafting(scene.parent) as draft:
                    draft.export(layer, names.EDITS)
                    runner.check(draft)
        finally:
            _EDITING.reset(before)
            # Layers are shared by name: what was not saved must not live on in memory.
            layer.Reload(force=True)


def being_edited(scene: Path) -> Usd.Stage | None:
    """The stage of a room that a block of `editing` around this call has open."""
    return _EDITING.get().get(scene.resolve())


def _check_composed(scene: Path) -> None:
    """Refuse what compose did not write, before anything is written beside it."""
    if not (scene.is_file() and (scene.parent / _EDITS).is_file()):
        raise InputError(
            f"this is not a composed room: it has no {_EDITS}",
            place=scene,
            remedy="compose a room first; other files can be edited in place with any USD tool",
        )


def _edits(stage: Usd.Stage, scene: Path) -> Sdf.Layer:
    wanted = (scene.parent / _EDITS).resolve()
    for layer in stage.GetLayerStack(includeSessionLayers=False):
        if layer.realPath and Path(layer.realPath).resolve() == wanted:
            return layer
    raise StageError(
        f"the scene does not use its {_EDITS}",
        place=scene,
        remedy="compose the room again, or take over what another program saved: "
        "orusd edit import-changes",
    )


# Changes of one file taken back, and made again: the bytes that it had before each of them.


@dataclass
class History:
    """What a file was before each change that a person made here.

    Attributes:
        file: The file, such as ``layers/edits.usda``.
    """

    file: Path
    _before: list[bytes] = field(default_factory=list)
    _after: list[bytes] = field(default_factory=list)
    _left: bytes = b""

    @contextmanager
    def step(self) -> Iterator[None]:
        """Remember what the file was, if the block changes it; nothing when the block raises."""
        before = self._content()
        yield
        now = self._content()
        if now == before:
            return
        if self._before and before != self._left:
            # Another program has written meanwhile: its work is not ours to take back.
            self._before.clear()
        self._before.append(before)
        self._after.clear()
        self._left = now

    def undo(self) -> None:
        """Take the last change back.

        Raises:
            InputError: There is none, or another program has written the file since.
            OutputError: The file cannot be written.
        """
        self._go(self._before, self._after, "there is nothing to undo")

    def redo(self) -> None:
        """Make the change again that was taken back last.

        Raises:
            InputError: There is none, or another program has written the file since.
            OutputError: The file cannot be written.
        """
        self._go(self._after, self._before, "there is nothing to redo")

    def told(self) -> dict[str, int | str]:
        """How many changes can be taken back and made again, and which version the file is."""
        version = hashlib.sha256(self._content()).hexdigest()[:16]
        return {"undo": len(self._before), "redo": len(self._after), "version": version}

    def _content(self) -> bytes:
        return untrusted.read_bytes(self.file, "usd" if self.file.suffix == ".usda" else "text")

    def _go(self, source: list[bytes], other: list[bytes], nothing: str) -> None:
        if not source:
            raise InputError(nothing)
        now = self._content()
        if now != self._left:
            source.clear()
            other.clear()
            raise InputError(
                "another program has changed this file since: undo would lose its changes",
                place=self.file,
                remedy="change it there, or continue from its current state",
            )
        atomic.write_bytes(self.file, source[-1])
        self._left = source.pop()
        other.append(now)
