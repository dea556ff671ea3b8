"""A room that was saved as one file: what in it differs from the room as it was composed."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from pxr import Sdf, Usd

from openrooms_usd import names

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
