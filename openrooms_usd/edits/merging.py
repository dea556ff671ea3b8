"""Layers become one: what a file says beside our layers, and that over the edits."""

from pathlib import Path
from typing import Final

from pxr import Sdf, Usd, UsdUtils

from openrooms_usd.edits.foreign import Foreign, anchored
from openrooms_usd.errors import StageError
from openrooms_usd.usd.files.diagnostics import UNREADABLE, reason
from openrooms_usd.usd.files.layers import apply_metadata, relative_assets

_RATE: Final = "timeCodesPerSecond"


def empty() -> Sdf.Layer:
    """A new layer in memory."""
    return Sdf.Layer.CreateAnonymous(".usda")


def copied(layer: Sdf.Layer) -> Sdf.Layer:
    """A copy in memory; its relative asset paths have lost their place."""
    copy = empty()
    copy.TransferContent(layer)
    return copy


def make_absolute(layer: Sdf.Layer, origin: Sdf.Layer) -> None:
    """Let the asset paths of a copy hold without the place of its original."""
    UsdUtils.ModifyAssetPaths(layer, lambda path: anchored(origin, path))


def with_sublayers(layer: Sdf.Layer, foreign: Foreign, source: Path) -> Sdf.Layer:
    """What a file says, itself and by the layers that it stacks besides ours, as one layer.

    Args:
        layer: The file.
        foreign: What it holds beside our layers.
        source: Where it lies, for messages.

    Raises:
        StageError: One of its layers cannot be opened.
    """
    copy = copied(layer)
    offsets = {
        anchored(layer, path): offset
        for path, offset in zip(layer.subLayerPaths, layer.subLayerOffsets, strict=True)
    }
    copy.subLayerPaths = list(foreign.sublayers)
    for index, path in enumerate(foreign.sublayers):
        _check_opens(path, source)
        copy.subLayerOffsets[index] = offsets[path]
    if not foreign.sublayers:
        return copy
    make_absolute(copy, layer)
    return UsdUtils.FlattenLayerStack(Usd.Stage.Open(copy), anchored, "")


def _check_opens(path: str, source: Path) -> None:
    """USD passes over layers that it cannot open, and what they say would be gone."""
    try:
        found = Sdf.Layer.FindOrOpen(path)
    except UNREADABLE:
        found = None
    if not found:
        raise StageError(
            f"its layer {path} cannot be opened",
            place=source,
            remedy="put it back, or remove it from the file's list of layers; nothing was changed",
        )


def merged_over(opinions: Sdf.Layer, edits: Path, outside: dict[str, None]) -> Sdf.Layer:
    """The edits with stronger opinions over them, as one layer.

    Args:
        opinions: The stronger ones; their asset paths are absolute.
        edits: The file of the edits. Asset paths of the result start at its folder.
        outside: Receives the absolute asset paths of the opinions, as keys.

    Raises:
        StageError: USD cannot merge them.
    """
    before = Sdf.Layer.FindOrOpen(str(edits))
    before.Reload()
    weaker, stronger, root = copied(before), copied(opinions), empty()
    make_absolute(weaker, before)
    weaker.subLayerPaths = []
    for key in set(stronger.pseudoRoot.ListInfoKeys()) - {_RATE}:
        stronger.pseudoRoot.ClearInfo(key)
    # Animated values keep their seconds, whichever rate the other program counts in.
    root.timeCodesPerSecond = before.timeCodesPerSecond
    root.subLayerPaths = [stronger.identifier, weaker.identifier]
    relative = relative_assets(edits.parent)

    def rewrite(layer: Sdf.Layer, path: str) -> str:
        if layer != weaker and path:
            outside[anchored(layer, path)] = None
        return relative(layer, path)

    try:
        merged = UsdUtils.FlattenLayerStack(Usd.Stage.Open(root), rewrite, "")
    except UNREADABLE as error:
        raise StageError(f"USD cannot merge it: {reason(error)}", place=edits) from error
    if not before.HasTimeCodesPerSecond():
        merged.ClearTimeCodesPerSecond()
    merged.subLayerPaths = list(before.subLayerPaths)
    for index, offset in enumerate(before.subLayerOffsets):
        merged.subLayerOffsets[index] = offset
    merged.customLayerData = before.customLayerData
    apply_metadata(merged)
    return merged
