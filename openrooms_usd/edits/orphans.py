"""Opinions of the edits that do nothing: what they speak about is not there, or hides itself."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final, Literal, TypeAlias

from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names, untrusted
from openrooms_usd.edits.foreign import own_layers
from openrooms_usd.errors import InputError
from openrooms_usd.spelling import nearest
from openrooms_usd.usd.files.diagnostics import UNREADABLE, reading
from openrooms_usd.usd.files.layers import open_stage, stacked_files

Reason: TypeAlias = Literal["missing", "instance", "variant", "target", "operation"]

REMEDIES: Final[dict[Reason, str]] = {
    "missing": "rename it to where the prim is now, or remove it",
    "instance": "write on the instance's root, choose a variant there, or set instanceable = false",
    "variant": "choose a variant that the prim has, or remove it",
    "target": "point it to where the prim is now, or remove it",
    "operation": "name the operation in xformOpOrder, or remove it",
}

# With more orphans than this, guesses are not printed.
_MOST_HINTS: Final = 50


@dataclass(frozen=True, order=True)
class Orphan:
    """An opinion without effect.

    Attributes:
        path: The prim or property of the layer.
        reason: Why it does nothing.
        message: The same in words.
        hint: The nearest path that is there; empty where none is near.
    """

    path: str
    reason: Reason
    message: str
    hint: str = ""

    @property
    def remedy(self) -> str:
        """What to do about it."""
        near = f"{self.hint} is near: " if self.hint else ""
        return near + REMEDIES[self.reason]

    def __str__(self) -> str:
        near = f" (near: {self.hint})" if self.hint else ""
        return f"{self.path}: {self.message}{near}"


def edit_layers(edits: Sdf.Layer) -> list[Sdf.Layer]:
    """The layer of the edits and all layers below it, strongest first."""
    found: dict[str, Sdf.Layer] = {}
    waiting: list[Sdf.Layer | None] = [edits]
    while waiting:
        layer = waiting.pop(0)
        if layer is None or layer.identifier in found:
            continue
        found[layer.identifier] = layer
        waiting.extend(_sublayer(layer, path) for path in layer.subLayerPaths)
    return list(found.values())


def _sublayer(layer: Sdf.Layer, path: str) -> Sdf.Layer | None:
    try:
        return Sdf.Layer.FindOrOpenRelativeToLayer(layer, path)
    except UNREADABLE:
        # USD's composition tells of it.
        return None


def orphans_of(out: Path, name: str = names.EDITS) -> tuple[Orphan, ...]:
    """The opinions of a composed room's edits that do nothing.

    Args:
        out: The folder that compose wrote.
        name: The layer to check: ``edits``, or another one that no step writes.

    Raises:
        InputError: There is no composed room, or its edits cannot be read.
    """
    untrusted.check_path(out)
    stack = own_layers(out)
    layer = stack[names.STACK.index(name)]
    if not layer.is_file():
        raise InputError(
            "no such file", place=layer, remedy="name the folder that orusd compose wrote"
        )
    # The stage keeps its layer alive.
    alone = open_stage(layer)
    edits = alone.GetRootLayer()
    if not (edits.rootPrims or edits.subLayerPaths):
        return ()
    with reading(layer):
        return tuple(find_orphans(stacked_files(stack), edit_layers(edits)))


def find_orphans(stage: Usd.Stage, layers: Iterable[Sdf.Layer]) -> list[Orphan]:
    """The opinions of some of a stage's layers that do nothing.

    Args:
        stage: The composed stage.
        layers: Those of its layers that are looked at.

    Returns:
        Sorted by path.
    """
    kept = list(layers)
    search = _Search(stage, frozenset(layer.identifier for layer in kept))
    return sorted({orphan for layer in kept for orphan in search.walk(list(layer.rootPrims))})


class _Search:
    """A walk through the specs of layers beside the stage that they are part of."""

    def __init__(self, stage: Usd.Stage, layers: frozenset[str]) -> None:
        self.stage = stage
        self.layers = layers
        self.hints = 0

    def walk(self, waiting: list[Sdf.PrimSpec]) -> Iterator[Orphan]:
        while waiting:
            spec = waiting.pop()
            prim = self.stage.GetPrimAtPath(spec.path.StripAllVariantSelections())
            if not (prim and prim.IsDefined()):
                if holds_opinions(spec):
                    message = "overrides a prim that does not exist"
                    yield Orphan(str(spec.path), "missing", message, self.nearest(spec.path))
                continue
            yield from self._variants(spec, prim)
            yield from self._targets(spec)
            yield from _operations(spec, prim)
            waiting.extend(self._variant_specs(spec, prim))
            # What lies below an inactive prim is hidden by intent.
            if prim.IsInstance():
                yield from self._below_instance(spec)
            elif prim.IsActive():
                waiting.extend(spec.nameChildren)

    def _below_instance(self, spec: Sdf.PrimSpec) -> Iterator[Orphan]:
        for child in spec.nameChildren:
            if holds_opinions(child):
                message = f"is below the instance {spec.name}, where USD ignores opinions"
                yield Orphan(str(child.path), "instance", message)

    def _variants(self, spec: Sdf.PrimSpec, prim: Usd.Prim) -> Iterator[Orphan]:
        """Selections and variants that no other layer has."""
        wanted = {(name, choice) for name, choice in spec.variantSelections.items() if choice}
        for name, choice in sorted(wanted):
            known = prim.GetVariantSets().GetVariantSet(name).GetVariantNames()
            if choice not in known:
                message = f"selects the variant {name} = {choice}, which does not exist"
                yield Orphan(str(spec.path), "variant", message, nearest(choice, known) or "")

    def _variant_specs(self, spec: Sdf.PrimSpec, prim: Usd.Prim) -> Iterator[Sdf.PrimSpec]:
        """What is written inside the variants that are chosen; others cannot be looked at."""
        for name, variants in spec.variantSets.items():
            chosen = prim.GetVariantSets().GetVariantSelection(name)
            if chosen in variants.variants:
                yield variants.variants[chosen].primSpec

    def _targets(self, spec: Sdf.PrimSpec) -> Iterator[Orphan]:
        for found in spec.properties:
            is_attribute = isinstance(found, Sdf.AttributeSpec)
            paths = found.connectionPathList if is_attribute else found.targetPathList
            for target in paths.GetAddedOrExplicitItems():
                if not self._is_there(target):
                    message = f"points to {target}, which does not exist"
                    yield Orphan(str(found.path), "target", message, self.nearest(target))

    def _is_there(self, path: Sdf.Path) -> bool:
        prim = self.stage.GetPrimAtPath(path.GetPrimPath())
        # Collections are targets by name, and need no property of it.
        return bool(prim) and (
            path.IsPrimPath()
            or path.name.startswith("collection:")
            or bool(prim.GetProperty(path.name))
        )

    def nearest(self, path: Sdf.Path) -> str:
        """A path that is there: of the same name elsewhere, or of a similar one beside it."""
        self.hints += 1
        if self.hints > _MOST_HINTS:
            return ""
        name = path.GetPrimPath().name
        if name in self._by_name:
            return self._by_name[name]
        parent = self.stage.GetPrimAtPath(path.GetPrimPath().GetParentPath())
        beside = filter(Usd.Prim.IsDefined, parent.GetAllChildren() if parent else ())
        near = nearest(name, [prim.GetName() for prim in beside]) or ""
        return f"{parent.GetPath()}/{near}" if near else ""

    @cached_property
    def _by_name(self) -> dict[str, str]:
        found: dict[str, str] = {}
        for prim in Usd.PrimRange.AllPrims(self.stage.GetPseudoRoot()):
            if prim.IsDefined():
                found.setdefault(prim.GetName(), str(prim.GetPath()))
        return found


def _operations(spec: Sdf.PrimSpec, prim: Usd.Prim) -> Iterator[Orphan]:
    """Transform operations that the composed order leaves out."""
    given = [found.name for found in spec.properties if found.name.startswith("xformOp:")]
    if not given or not prim.IsA(UsdGeom.Xformable):
        return
    order = {
        str(name).removeprefix("!invert!")
        for name in UsdGeom.Xformable(prim).GetXformOpOrderAttr().Get() or ()
    }
    for name in sorted(set(given) - order):
        message = "authors an operation that is not in the prim's xformOpOrder: it has no effect"
        yield Orphan(f"{spec.path}.{name}", "operation", message)


def holds_opinions(spec: Sdf.PrimSpec) -> bool:
    """Whether an over says anything; an empty one, left behind by a tool, does no harm."""
    return bool(
        spec.properties
        or spec.specifier != Sdf.SpecifierOver
        or spec.hasReferences
        or any(holds_opinions(child) for child in spec.nameChildren)
        or set(spec.ListInfoKeys()) - {"specifier"}
    )
