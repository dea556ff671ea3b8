"""A room that was saved as one file: what in it differs from the room as it was composed."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from pxr import Sdf, Usd, UsdUtils

from openrooms_usd import names
from openrooms_usd.edits.foreign import Foreign, anchored
from openrooms_usd.errors import StageError
from openrooms_usd.usd.files.diagnostics import UNREADABLE, reason
from openrooms_usd.usd.files.layers import apply_metadata, relative_assets

# Where USD puts what equal instances share when it flattens a stage.
_PROTOTYPES = "Flattened_Prototype_"


@dataclass
class Differences:
    """What a saved stage says otherwise than a composed one, as sparse opinions.

    Attributes:
        saved: The stage as it was saved.
        base: The stage as it is composed.
        opinions: Receives what differs.
        left: Receives a sentence for what cannot be said in a layer of edits.
        compared: How many attributes and relationships were looked at.
    """

    saved: Usd.Stage
    base: Usd.Stage
    opinions: Sdf.Layer = field(default_factory=lambda: Sdf.Layer.CreateAnonymous(".usda"))
    left: list[str] = field(default_factory=list)
    compared: int = 0

    def find(self) -> None:
        """Compare both stages, prim by prim and value by value, without any tolerance."""
        self._compare_all()
        for path in _missing(self.saved, self.base):
            self._over(path).active = False

    def _compare_all(self) -> None:
        walk = iter(Usd.PrimRange.AllPrims(self.saved.GetPseudoRoot()))
        for prim in walk:
            if prim.IsPseudoRoot():
                continue
            if prim.GetName().startswith(_PROTOTYPES) or prim.IsAbstract():
                walk.PruneChildren()
                continue
            known = self.base.GetPrimAtPath(prim.GetPath())
            if not known:
                walk.PruneChildren()
                self._adopt_new(prim)
                continue
            self._compare(prim, known)
            if prim.IsInstance():
                self._compare_shared(prim)

    def _adopt_new(self, prim: Usd.Prim) -> None:
        spec = prim.GetPrimStack()[0]
        if _uses_prototype(spec):
            self.left.append(f"{prim.GetPath()} is a copy of an instance: reference its asset")
            return
        self._over(prim.GetPath().GetParentPath())
        Sdf.CopySpec(spec.layer, spec.path, self.opinions, prim.GetPath())

    def _compare(self, prim: Usd.Prim, known: Usd.Prim) -> None:
        path = prim.GetPath()
        if prim.IsActive() != known.IsActive():
            self._over(path).active = prim.IsActive()
        if prim.GetTypeName() != known.GetTypeName():
            self._over(path).typeName = prim.GetTypeName()
        if prim.GetKind() != known.GetKind():
            self._over(path).kind = prim.GetKind()
        added = [api for api in prim.GetAppliedSchemas() if api not in known.GetAppliedSchemas()]
        if added:
            schemas = Sdf.TokenListOp()
            schemas.prependedItems = added
            self._over(path).SetInfo("apiSchemas", schemas)
        for found in prim.GetAuthoredProperties():
            self.compared += 1
            if not _equal(found, known.GetProperty(found.GetName())):
                self._copy(found)

    def _copy(self, found: Usd.Property) -> None:
        path = found.GetPath()
        spec = found.GetPropertyStack(Usd.TimeCode.Default())[0]
        self._over(path.GetPrimPath())
        Sdf.CopySpec(spec.layer, spec.path, self.opinions, path)

    def _over(self, path: Sdf.Path) -> Sdf.PrimSpec:
        """The spec of a prim among the opinions; an instance that it is inside of is opened."""
        for above in path.GetPrefixes():
            known = self.base.GetPrimAtPath(above)
            if known and known.IsInstance() and above != path:
                Sdf.CreatePrimInLayer(self.opinions, above).instanceable = False
        return Sdf.CreatePrimInLayer(self.opinions, path)

    def _compare_shared(self, prim: Usd.Prim) -> None:
        """Instances show what they share: a difference there has no place of its own."""
        for part in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
            known = self.base.GetPrimAtPath(part.GetPath())
            if part == prim:
                continue
            same = known and all(
                _equal(found, known.GetAttribute(found.GetName()))
                for found in part.GetAuthoredAttributes()
            )
            if not same:
                self.left.append(
                    f"{part.GetPath()} was changed inside an instance: "
                    "set instanceable = false on the object first"
                )
                return


def _equal(found: Usd.Property, known: Usd.Property) -> bool:
    if isinstance(found, Usd.Relationship):
        return bool(known) and found.GetTargets() == known.GetTargets()
    if not known:
        return not (found.HasAuthoredValue() or found.HasAuthoredConnections())
    times = found.GetTimeSamples()
    if found.GetConnections() != known.GetConnections() or times != known.GetTimeSamples():
        return False
    moments = [Usd.TimeCode.Default(), *map(Usd.TimeCode, times)]
    return all(_plain(found.Get(time)) == _plain(known.Get(time)) for time in moments)


def _plain(value: object) -> object:
    """Files are equal by what they are, however they were named."""
    if isinstance(value, Sdf.AssetPath):
        return value.resolvedPath or value.path
    return value


def _missing(saved: Usd.Stage, base: Usd.Stage) -> Iterator[Sdf.Path]:
    """The topmost prims of the world that are not in the saved stage any more."""
    walk = iter(Usd.PrimRange.AllPrims(base.GetPrimAtPath(names.WORLD)))
    for prim in walk:
        there = saved.GetPrimAtPath(prim.GetPath())
        if not there and prim.IsDefined() and prim.IsActive():
            yield prim.GetPath()
        if not there or not there.IsActive():
            walk.PruneChildren()


def _uses_prototype(spec: Sdf.PrimSpec) -> bool:
    references = spec.referenceList.GetAddedOrExplicitItems()
    inner = any(_PROTOTYPES in str(reference.primPath) for reference in references)
    return inner or any(_uses_prototype(child) for child in spec.nameChildren)


# Layers become one: what a file says beside our layers, and that over the edits.

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
            remedy="put it back, or take it off the file's list of layers; nothing was changed",
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
