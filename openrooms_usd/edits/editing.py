"""People's changes made in Python: the composed stage, open such that they go to the edits."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import MappingProxyType
from typing import Final

from pxr import Sdf, Usd

from openrooms_usd import claims, names
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.stages import runner
from openrooms_usd.stages.draft import drafting
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
        InputError: It is no composed room.
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
            f"this is no composed room: it has no {_EDITS}",
            place=scene,
            remedy="compose a room first; any USD tool edits other files in place",
        )


def _edits(stage: Usd.Stage, scene: Path) -> Sdf.Layer:
    wanted = (scene.parent / _EDITS).resolve()
    for layer in stage.GetLayerStack(includeSessionLayers=False):
        if layer.realPath and Path(layer.realPath).resolve() == wanted:
            return layer
    raise StageError(
        f"the scene does not use its {_EDITS}",
        place=scene,
        remedy="compose the room again, or adopt what another program saved: orusd edits adopt",
    )
