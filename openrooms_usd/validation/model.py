"""What a rule is, what it looks at and what it finds."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal

from pxr import Sdf, Usd, UsdGeom, UsdShade, UsdUtils

from openrooms_usd import names
from openrooms_usd.edits.orphans import edit_layers
from openrooms_usd.usd.files.diagnostics import UNREADABLE
from openrooms_usd.usd.files.layers import prim_specs
from openrooms_usd.usd.semantics import WORDS, own_labels
from openrooms_usd.validation.roomview import RoomView

Severity = Literal["error", "warning"]

_EDITS: Final = f"{names.LAYERS}/{names.EDITS}.usda"

_PRIMS: Final = Usd.TraverseInstanceProxies(
    Usd.PrimIsActive & Usd.PrimIsDefined & Usd.PrimIsLoaded & ~Usd.PrimIsAbstract
)


@dataclass(frozen=True, order=True)
class Finding:
    """One thing that is wrong with a stage.

    Attributes:
        severity: An error breaks the stage for others; a warning breaks a habit of this package.
        code: The rule, such as ``extent`` or ``usdValidation:CompositionErrorTest``.
        place: The prim, property or layer.
        message: What is wrong there.
        remedy: What to do about it; empty where the message says it.
    """

    severity: Severity
    code: str
    place: str
    message: str
    remedy: str = ""


Complaint = tuple[str, str]
"""A place, and what is wrong there."""


@dataclass(frozen=True)
class Rule:
    """One rule of ours.

    Attributes:
        code: Its stable name.
        check: Gives the complaints about a stage.
        remedy: What to do about them.
        advice: Whether it is no more than a warning in our own scenes too.
    """

    code: str
    check: "Callable[[Subject], Iterable[Complaint]]"
    remedy: str
    advice: bool = False


class Subject:
    """A stage under test, with what several rules look at."""

    def __init__(self, stage: Usd.Stage) -> None:
        self.stage = stage
        self.root: Sdf.Layer = stage.GetRootLayer()
        self.stack: tuple[Sdf.Layer, ...] = tuple(stage.GetLayerStack(False))

    @cached_property
    def home(self) -> str:
        """The scene's folder, with a slash at its end."""
        return str(self.root.realPath).rpartition("/")[0] + "/"

    @cached_property
    def ours(self) -> bool:
        """Whether this package wrote the stage, and it is a scene and not a part of one."""
        world = self.stage.GetPrimAtPath(names.WORLD)
        creator = self.root.customLayerData.get("creator")
        return bool(creator == names.CREATOR and world and world.IsDefined())

    @cached_property
    def prims(self) -> tuple[Usd.Prim, ...]:
        """Every prim that shows; what equal instances share is listed once, below the first."""
        return tuple(_distinct_prims(self.stage))

    @cached_property
    def gprims(self) -> tuple[Usd.Prim, ...]:
        """The geometry among `prims`, guides left out."""
        return tuple(
            prim
            for prim in self.prims
            if prim.IsA(UsdGeom.Gprim)
            and UsdGeom.Imageable(prim).ComputePurpose() != UsdGeom.Tokens.guide
        )

    @cached_property
    def room(self) -> RoomView:
        """The room as people see it."""
        return RoomView(self.stage)

    @cached_property
    def asset_paths(self) -> tuple[tuple[Sdf.Layer, str], ...]:
        """Every asset path that the used layers hold, unselected variants included."""
        found: list[tuple[Sdf.Layer, str]] = []

        def note(layer: Sdf.Layer, info: UsdUtils.DependencyInfo) -> UsdUtils.DependencyInfo:
            found.append((layer, info.rawAssetPath))
            return info

        # A layer that cannot be read is found by USD's own validators.
        with suppress(*UNREADABLE):
            UsdUtils.ComputeAllDependencies(self.root.identifier, note)
        return tuple(found)

    @cached_property
    def by_hand(self) -> frozenset[Sdf.Path]:
        """The topmost prims that people made themselves, in the layer of the edits."""
        edits = next((layer for layer in self.stack if self.name(layer) == _EDITS), None)
        own = set(edit_layers(edits)) if edits else set()
        found: set[Sdf.Path] = set()
        for spec in (spec for layer in own for spec in prim_specs(layer)):
            if spec.specifier == Sdf.SpecifierDef and not found.intersection(
                spec.path.GetPrefixes()
            ):
                prim = self.stage.GetPrimAtPath(spec.path)
                # USD shows nothing where a layer writes below an instance.
                stack = prim.GetPrimStack() if prim else ()
                # What they refer to defines it too; what counts are the layers of the scene.
                definers = {s.layer for s in stack if s.specifier == Sdf.SpecifierDef}
                if definers and definers.intersection(self.stack) <= own:
                    found.add(spec.path)
        return frozenset(found)

    def is_by_hand(self, place: str) -> bool:
        """Whether a place is a prim that people made themselves, or lies below one."""
        if not Sdf.Path.IsValidPathString(place):
            return False
        return not self.by_hand.isdisjoint(Sdf.Path(place).GetPrimPath().GetPrefixes())

    def name(self, layer: Sdf.Layer) -> str:
        """A layer's file name as a person knows it: relative to the scene's folder."""
        return str(layer.realPath or layer.identifier).removeprefix(self.home)


def _distinct_prims(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    seen: set[tuple[Sdf.Path, bool, bool]] = set()
    walk = iter(Usd.PrimRange(stage.GetPseudoRoot(), _PRIMS))
    for prim in walk:
        if not prim.IsPseudoRoot():
            yield prim
        if prim.IsInstance():
            # What lies below differs between instances only by what it inherits from above.
            key = (prim.GetPrototype().GetPath(), has_label(prim), has_material(prim))
            if key in seen:
                walk.PruneChildren()
            seen.add(key)


def has_label(prim: Usd.Prim) -> bool:
    """Whether a prim, or one above it, says what it is."""
    while prim and not prim.IsPseudoRoot():
        if not own_labels(prim).keys().isdisjoint(WORDS):
            return True
        prim = prim.GetParent()
    return False


def has_material(prim: Usd.Prim) -> bool:
    """Whether a material is bound to a prim, directly, from above or by a collection."""
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
    return bool(material)
