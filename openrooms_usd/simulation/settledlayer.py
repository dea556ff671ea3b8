"""The layer that a simulation writes: where it lies, what it does not see, how it is saved."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pxr import Sdf, Usd

from openrooms_usd import claims, ledger, names
from openrooms_usd.errors import InputError
from openrooms_usd.usd.files import layers

_METADATA: Final = ("defaultPrim", "upAxis", "metersPerUnit", "kilogramsPerUnit")


@dataclass(frozen=True, eq=False)
class SettledRoom:
    """A stage as it was described, and the layer that receives where its things come to rest.

    Attributes:
        stage: Its edit target is the layer, just below the edits of a composed room.
        layer: Empty at first.
        target: Where it will be saved.
        composed: The folder of the composed room that it becomes a part of; None without one.
    """

    stage: Usd.Stage
    layer: Sdf.Layer
    target: Path
    composed: Path | None

    def save(self) -> None:
        """Save the layer, and let the room that it belongs to find it.

        Raises:
            OutputError: It cannot be written.
        """
        if self.composed is None:
            with claims.output(self.target):
                layers.export(self.layer, self.target)
            return
        from openrooms_usd.steps import draft, runner

        with draft.drafting(self.composed) as room:
            room.check_unchanged(names.SETTLED)
            room.export(self.layer, names.SETTLED)
            runner.write_scene(room)


@contextmanager
def settling(path: Path, out: Path | None) -> Iterator[SettledRoom]:
    """Open a stage without what an earlier run has written to the same layer.

    Args:
        path: The USD file; of a composed room its ``scene.usda``.
        out: The layer; None stands for the one of a composed room.

    Raises:
        InputError: The file is not USD, or it is not a composed room and ``out`` is missing.
    """
    source = layers.open_stage(path)
    own = path.parent / names.LAYERS / f"{names.SETTLED}.usda"
    composed = _is_composed(path, source.GetRootLayer())
    target = _target(path, out, own if composed else None)
    used = {Path(layer.realPath).resolve() for layer in source.GetUsedLayers() if layer.realPath}
    if target.resolve() in used - {own.resolve()}:
        raise InputError(
            "this layer is a part of the scene, and the poses would replace it",
            place=target,
            remedy="give a USD file of its own, such as -o settled.usda",
        )
    # Poses of an earlier run do not count, wherever these will lie.
    earlier = {target.resolve(), *([own.resolve()] if composed else [])}
    stronger, weaker = _around(path, earlier, source.GetRootLayer()) if composed else ([], [path])
    layer = Sdf.Layer.CreateAnonymous(".usda")
    for key in _METADATA:
        if source.GetRootLayer().pseudoRoot.HasInfo(key):
            value = source.GetRootLayer().pseudoRoot.GetInfo(key)
            layer.pseudoRoot.SetInfo(key, value)
    ours = composed and target.resolve() == own.resolve()
    with (
        claims.claimed(path.parent) if ours else nullcontext(),
        layers.stacked(layer, stronger, weaker) as stage,
    ):
        # Long before it is written.
        if not ours:
            claims.check_output(target)
        elif not ledger.may_replace(target):
            from openrooms_usd.steps.draft import changed

            raise changed(target)
        for key in _METADATA:
            if layer.pseudoRoot.HasInfo(key):
                stage.GetRootLayer().pseudoRoot.SetInfo(key, layer.pseudoRoot.GetInfo(key))
        for used in stage.GetUsedLayers():
            if used.realPath and Path(used.realPath).resolve() in earlier:
                stage.MuteLayer(used.identifier)
        yield SettledRoom(stage, layer, target, path.parent if ours else None)


def _is_composed(path: Path, root: Sdf.Layer) -> bool:
    """Whether this is the root layer of a room of ours: sublayers in their folder, and no prim."""
    known = (path.parent / names.LAYERS / f"{names.STEPS[0]}.usda").is_file()
    return path.name == names.SCENE and known and not root.rootPrims


def _around(path: Path, without: set[Path], root: Sdf.Layer) -> tuple[list[Path], list[Path]]:
    """The layers of a composed room above the new one, and those below, some left out."""
    files = [path.parent / str(name) for name in root.subLayerPaths]
    edits = f"{names.EDITS}.usda"
    left_out = {file.resolve() for file in without}
    others = [file for file in files if file.resolve() not in left_out]
    return [f for f in others if f.name == edits], [f for f in others if f.name != edits]


def _target(path: Path, out: Path | None, own: Path | None) -> Path:
    target = out or own
    if target is None:
        raise InputError(
            "this is not a composed room, so the layer needs a place",
            place=path,
            remedy="give a file for the poses, such as -o settled.usda",
        )
    if target.suffix not in (".usda", ".usd", ".usdc") or target.resolve() == path.resolve():
        raise InputError(
            f"the poses cannot be written to {target.name}",
            place=target,
            remedy="give a USD file of its own, such as -o settled.usda",
        )
    return target


def choose_look(stage: Usd.Stage, look: str, path: Path) -> None:
    """Choose the variant ``look`` of every object that has one of that name, for this stage alone.

    Args:
        stage: The choice is made in its session layer.
        look: The variant's name.
        path: The stage's file, for messages.

    Raises:
        InputError: Nothing has it.
    """
    chosen = False
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for found in [prim.GetPath() for prim in stage.Traverse()]:
            # What another look alone has is gone by then.
            if prim := stage.GetPrimAtPath(found):
                looks = prim.GetVariantSet("look")
                if look in looks.GetVariantNames():
                    chosen |= looks.SetVariantSelection(look)
    if not chosen:
        raise InputError(
            f"nothing has a look {look!r}", place=path, remedy="the variant sets named look say"
        )
