"""What a person means who points at a part of a room: it, its object, or all of its kind."""

from typing import Final, Literal, TypeAlias, get_args

from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.errors import InputError
from openrooms_usd.library.styles.assignment.kinds import kind_of
from openrooms_usd.usd.semantics import read_label

Scope: TypeAlias = Literal["part", "alike", "object", "category"]

SCOPES: Final[dict[Scope, str]] = {
    "part": "this part",
    "object": "the whole object",
    "alike": "parts like this one, of its category",
    "category": "all objects of its category",
}
assert set(SCOPES) == set(get_args(Scope))

# What holds objects: each of its children is one.
_GROUPS: Final = (names.FURNITURE, names.OPENINGS)


def prim_at(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A prim of the composed stage.

    Raises:
        InputError: There is none.
    """
    prim = stage.GetPrimAtPath(path) if Sdf.Path.IsValidPathString(path) else None
    if not prim or prim.IsPseudoRoot():
        raise InputError("there is no such prim", place=path, remedy="was the room composed again?")
    return prim


def object_of(prim: Usd.Prim) -> Usd.Prim:
    """The piece of furniture, door or window that a part belongs to; of the shell the part."""
    for above in prim.GetPath().GetPrefixes():
        if str(above.GetParentPath()) in _GROUPS:
            return prim.GetStage().GetPrimAtPath(above)
    return prim


def furniture(stage: Usd.Stage, name: str) -> Usd.Prim:
    """An object of the room by its name.

    Raises:
        InputError: There is none.
    """
    path = Sdf.Path(names.FURNITURE)
    prim = stage.GetPrimAtPath(path.AppendChild(name)) if Sdf.Path.IsValidIdentifier(name) else None
    if not prim or not prim.IsA(UsdGeom.Xformable):
        raise InputError("there is no such object", place=f"{path}/{name}")
    return prim


def all_furniture(stage: Usd.Stage) -> list[Usd.Prim]:
    """The objects of the room."""
    group = stage.GetPrimAtPath(names.FURNITURE)
    return [each for each in group.GetChildren() if each.IsA(UsdGeom.Xformable)] if group else []


def parts_meant(stage: Usd.Stage, path: str, scope: Scope) -> list[Sdf.Path]:
    """The surfaces that are meant by pointing at one of them.

    Bulbs are meant only by themselves: a lamp all of wood still has a bulb of glass.

    Args:
        stage: The composed stage.
        path: The selected part.
        scope: How much of the room.

    Raises:
        InputError: There is no such part.
    """
    part = prim_at(stage, path)
    if scope == "part":
        return [each.GetPath() for each in _surfaces(part)]
    root = object_of(part)
    roots = [root] if scope == "object" else _of_category(stage, root)
    found = [each for one in roots for each in _surfaces(one)]
    kind = _kind(part)
    return [
        each.GetPath()
        for each in found
        if (_kind(each) == kind if scope == "alike" else _kind(each) != names.LIGHT_BULB)
    ]


def _surfaces(prim: Usd.Prim) -> list[Usd.Prim]:
    inner = Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
    return [each for each in inner if each.IsA(UsdGeom.Gprim)]


def _kind(prim: Usd.Prim) -> str:
    return kind_of(read_label(prim, names.PART) or "")


def _of_category(stage: Usd.Stage, root: Usd.Prim) -> list[Usd.Prim]:
    """All objects, or parts of the shell, that are what one of them is."""
    category = read_label(root, names.CATEGORY)
    group = root.GetParent()
    if str(group.GetPath()) in _GROUPS:
        return [
            each for each in group.GetChildren() if read_label(each, names.CATEGORY) == category
        ]
    room = stage.GetPrimAtPath(names.ROOM)
    return [each for each in _surfaces(room) if read_label(each, names.CATEGORY) == category]
