"""Flattening a stage, always to the same bytes."""

import re
from collections.abc import Iterator
from typing import Final

from pxr import Sdf, Usd, UsdPhysics

# What USD calls the prototypes of instances in a flattened layer, numbered as it happened to find
# them, which differs between runs.
_PROTOTYPE: Final = re.compile(r"\bFlattened_Prototype_\d+\b")

# What cannot stay inside an instance.
_OPEN: Final = (UsdPhysics.RigidBodyAPI, UsdPhysics.CollisionAPI)


def flattened(stage: Usd.Stage) -> Sdf.Layer:
    """One layer with everything; instances stay, but those in which something moves or collides.

    Engines write poses where bodies are, and cannot write inside an instance; PhysX finds no
    friction in one (ovphysx 0.7: bindings are not published at the paths of instances' content).

    Args:
        stage: Any stage; it is not changed.
    """
    session = Sdf.Layer.CreateAnonymous(".usda")
    session.TransferContent(stage.GetSessionLayer())
    copy = Usd.Stage.Open(stage.GetRootLayer(), session, stage.GetPathResolverContext())
    copy.SetEditTarget(session)
    while instances := {_outermost(prim) for prim in _hidden(copy)}:
        for path in sorted(instances):
            copy.GetPrimAtPath(path).SetInstanceable(False)
    return ordered(copy.Flatten(addSourceFileComment=False))


def ordered(flat: Sdf.Layer) -> Sdf.Layer:
    """The same layer with prototypes numbered by their first use, and fields by their names.

    Flattening leaves fields in the order of addresses in memory, which a binary file would keep.
    """
    numbers = {name: f"Flattened_Prototype_{i}" for i, name in enumerate(_prototypes(flat), 1)}
    text = _PROTOTYPE.sub(lambda match: numbers.get(match[0], match[0]), flat.ExportToString())
    read = _read(text)
    result = Sdf.Layer.CreateAnonymous(".usda")
    for key in read.pseudoRoot.ListInfoKeys():
        result.pseudoRoot.SetInfo(key, read.pseudoRoot.GetInfo(key))
    shown = [prim.path for prim in read.rootPrims if prim.name not in numbers.values()]
    for path in [*shown, *(Sdf.Path(f"/{name}") for name in numbers.values())]:
        Sdf.CopySpec(read, path, result, path)
    return _read(result.ExportToString())


def _read(text: str) -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text)
    return layer


def _prototypes(flat: Sdf.Layer) -> list[str]:
    """Their names in the order in which the scene, and then they themselves, use them."""
    found: dict[str, None] = {}
    waiting = [prim for prim in flat.rootPrims if not _PROTOTYPE.fullmatch(prim.name)]
    while waiting:
        new = [name for prim in waiting for name in _uses(prim) if name not in found]
        found |= dict.fromkeys(new)
        waiting = [flat.GetPrimAtPath(f"/{name}") for name in dict.fromkeys(new)]
    return list(found)


def _uses(prim: Sdf.PrimSpec) -> Iterator[str]:
    for reference in prim.referenceList.GetAddedOrExplicitItems():
        name = str(reference.primPath).lstrip("/")
        if not reference.assetPath and _PROTOTYPE.fullmatch(name):
            yield name
    for child in prim.nameChildren:
        yield from _uses(child)


def _hidden(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.IsInstanceProxy() and any(map(prim.HasAPI, _OPEN)):
            yield prim


def _outermost(prim: Usd.Prim) -> Sdf.Path:
    while prim.IsInstanceProxy():
        prim = prim.GetParent()
    return prim.GetPath()
