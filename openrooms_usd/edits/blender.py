"""Which object of a Blender export is which prim of the room.

Blender imports USD into a scene of its own and exports that anew. Its objects keep the order of our
prims, but everything is below ``/root``, or below another prim or none. Names that exist twice in a
Blender file have a number behind them (``Geometry.003``). An object and its data are two prims of
one name. An Xform with only one mesh below it has merged with that mesh.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdLux

from openrooms_usd import names
from openrooms_usd.usd.places.frames import TIME

PROPERTIES: Final = "userProperties:blender:"
OBJECT: Final = f"{PROPERTIES}object_name"
DATA: Final = f"{PROPERTIES}data_name"
# Where Blender puts all materials, beside the objects.
MATERIALS: Final = "_materials"

# What Blender puts behind names that it has already; names of prims have no points.
_COUNTED: Final = re.compile(r"\.\d{3,}$")
# The same where only the prim's name is left; copies of instances are counted once more.
_NUMBERED: Final = re.compile(r"_\d+$")


def is_blenders(layer: Sdf.Layer) -> bool:
    """Whether Blender wrote a layer."""
    if layer.documentation.startswith("Blender "):
        return True
    tops = [*layer.rootPrims, *(child for spec in layer.rootPrims for child in spec.nameChildren)]
    return any("Blender" in spec.customData or OBJECT in spec.properties for spec in tops)


@dataclass(frozen=True, eq=False)
class Pair:
    """An object of Blender and the prim of the room that it stands for.

    Attributes:
        ours: The prim that carries its place.
        theirs: The object.
        shape: The prim of ours that shows something; ``ours`` itself, or what is below it where
            Blender has made both one.
        data: The same of Blender's; the object itself where both were exported as one prim.
    """

    ours: Usd.Prim
    theirs: Usd.Prim
    shape: Usd.Prim
    data: Usd.Prim

    def local(self) -> Gf.Matrix4d:
        """Where Blender has the prim that carries the place, in its parent's frame."""
        found = _local(self.theirs)
        return found if self.shape == self.ours else _local(self.shape).GetInverse() * found

    def distance(self) -> float:
        """How far it was moved and turned; metres and differences of unit vectors."""
        return float(np.abs(np.array(self.local()) - np.array(_local(self.ours))).max())


@dataclass(eq=False)
class Pairing:
    """The room and Blender's export side by side.

    Attributes:
        pairs: What is in both, parents first.
        added: Objects that only Blender has, each with the prim of ours that it lies below.
        missing: The topmost prims that only the room has.
    """

    pairs: list[Pair] = field(default_factory=list)
    added: list[tuple[Usd.Prim, Usd.Prim]] = field(default_factory=list)
    missing: list[Usd.Prim] = field(default_factory=list)

    @classmethod
    def of(cls, base: Usd.Stage, saved: Usd.Stage) -> "Pairing":
        """Compare a composed room with what Blender has exported of it."""
        found, world = cls(), base.GetPrimAtPath(names.WORLD)
        tops = _objects(container(saved))
        worlds = [child for child in tops if named(child) == world.GetName()]
        # New objects lie beside the world in the file, but inside it in the room.
        beside = [
            child
            for child in tops
            if child not in worlds and not base.GetPrimAtPath(f"/{named(child)}")
        ]
        inside = [child for child in worlds for child in _objects(child)]
        found.pairs.extend(Pair(world, child, world, child) for child in worlds)
        found._match(world, [*inside, *beside])
        return found

    def _match(self, ours: Usd.Prim, objects: Sequence[Usd.Prim]) -> None:
        matches = _matched(list(_choices(ours)), objects)
        theirs = {pair.theirs for pair in matches}
        there = {pair.ours for pair in matches}
        self.added.extend((ours, child) for child in objects if child not in theirs)
        self.missing.extend(prim for prim in _children(ours) if prim not in there)
        for pair in matches:
            self.pairs.append(pair)
            if pair.shape == pair.ours:
                below = _objects(pair.theirs)
                self._match(pair.ours, [x for x in below if not _is_data(x, pair.ours)])


def container(saved: Usd.Stage) -> Usd.Prim:
    """The prim below which Blender put its scene: ``/root``, one of another name, or none."""
    root = saved.GetPseudoRoot()
    inner = [prim for prim in root.GetChildren() if prim.GetCustomDataByKey("Blender")]
    return inner[0] if inner else root


def named(prim: Usd.Prim, kind: str = OBJECT) -> str:
    """What an object was called before Blender counted it; with `DATA`, a material or a mesh."""
    attribute = prim.GetAttribute(kind)
    return _COUNTED.sub("", str(attribute.Get())) if attribute else prim.GetName()


def is_named(prim: Usd.Prim, name: str, kind: str = OBJECT) -> bool:
    """Whether an exported prim had a name before Blender counted it."""
    if prim.GetAttribute(kind):
        return bool(Tf.MakeValidIdentifier(named(prim, kind)) == name)
    return re.fullmatch(rf"{re.escape(name)}(_\d+)*", prim.GetName()) is not None


def _objects(parent: Usd.Prim) -> list[Usd.Prim]:
    """The children of an exported prim that are objects."""
    return [
        prim
        for prim in _children(parent)
        if UsdGeom.Imageable(prim)
        and prim.GetName() != MATERIALS
        and not prim.IsA(UsdLux.DomeLight)
        and not prim.IsA(UsdGeom.Subset)
    ]


def _is_data(prim: Usd.Prim, parent: Usd.Prim) -> bool:
    """Whether an exported prim is the data of the object above it, which stands for ``parent``."""
    if prim.GetAttribute(OBJECT):
        return False
    return bool(prim.GetAttribute(DATA)) or _is_shape(parent)


def _is_shape(prim: Usd.Prim) -> bool:
    """Whether a prim is what Blender has as the data of an object."""
    return bool(prim.IsA(UsdGeom.Boundable) or prim.IsA(UsdGeom.Camera))


def _children(prim: Usd.Prim) -> list[Usd.Prim]:
    return list(prim.GetFilteredChildren(Usd.TraverseInstanceProxies()))


def _choices(parent: Usd.Prim) -> Iterator[tuple[str, Usd.Prim, Usd.Prim]]:
    """What may have become of the children of a prim: name, prim, and what it shows."""
    for child in _children(parent):
        yield child.GetName(), child, child
        below = _children(child)
        if child.GetTypeName() == "Xform" and len(below) == 1 and _is_shape(below[0]):
            yield below[0].GetName(), child, below[0]
            yield child.GetName(), child, below[0]


def _matched(
    choices: Sequence[tuple[str, Usd.Prim, Usd.Prim]], objects: Iterable[Usd.Prim]
) -> list[Pair]:
    """One object for each prim: by its exact name, and of several the one that is nearest."""
    known = {name for name, _, _ in choices}
    possible = []
    for theirs in objects:
        name, shows = _match_name(theirs, known), _shows(theirs)
        for number, (choice, ours, shape) in enumerate(choices):
            if choice == name and shows in (None, _is_shape(shape)):
                pair = Pair(ours, theirs, shape, _data(theirs, shape))
                counted = shape == ours and _prim_name_of(theirs) != name
                possible.append((counted, pair.distance(), number, pair))
    possible.sort(key=lambda found: found[:3])
    taken: dict[Usd.Prim, Pair] = {}
    used: set[Usd.Prim] = set()
    for *_, pair in possible:
        if pair.ours not in taken and pair.theirs not in used:
            taken[pair.ours] = pair
            used.add(pair.theirs)
    return sorted(taken.values(), key=lambda pair: str(pair.ours.GetPath()))


def _prim_name_of(theirs: Usd.Prim) -> str:
    """An object's name as it would be a prim's."""
    attribute = theirs.GetAttribute(OBJECT)
    return str(Tf.MakeValidIdentifier(attribute.Get())) if attribute else str(theirs.GetName())


def _match_name(theirs: Usd.Prim, known: set[str]) -> str:
    """An object's name among those that there are; where Blender wrote none, by its prim."""
    name = _prim_name_of(theirs)
    if theirs.GetAttribute(OBJECT):
        return name if name in known else named(theirs)
    while name not in known and _NUMBERED.search(name):
        name = _NUMBERED.sub("", name)
    return name


def _shows(theirs: Usd.Prim) -> bool | None:
    """Whether an object has data that can be seen; None where Blender does not say."""
    data = [child for child in _children(theirs) if child.GetAttribute(DATA)]
    if theirs.GetAttribute(DATA) or any(not child.GetAttribute(OBJECT) for child in data):
        return True
    return False if theirs.GetAttribute(OBJECT) else None


def _data(theirs: Usd.Prim, shape: Usd.Prim) -> Usd.Prim:
    return next((child for child in _children(theirs) if _is_data(child, shape)), theirs)


def _local(prim: Usd.Prim) -> Gf.Matrix4d:
    placed = UsdGeom.Xformable(prim)
    return placed.GetLocalTransformation(TIME) if placed else Gf.Matrix4d(1.0)
