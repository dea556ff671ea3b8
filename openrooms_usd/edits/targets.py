"""What a person means who points at a part of a room: it, its object, or all of its kind."""

from typing import Final, Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.library.styles.assignment.kinds import kind_of
from openrooms_usd.stages.alignment.surroundings import Surroundings
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
        raise InputError("there is no such prim", place=path, remedy="was the room composed anew?")
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
        path: The part that somebody points at.
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


# Where an object comes to stand that somebody has put about there: along walls, and flush to them.
#
# Sides that are nearly parallel to the nearest wall become parallel to it, and sides that are near
# a wall, or beyond it, come flush to it. What hangs on walls hangs on the nearest one.

# Nearer than this a side comes to its wall, and turned by less it turns with it.
REACH_M: Final = 0.15
TURN_DEG: Final = 8.0
# What is farther behind a wall was not put there by mistake.
_BEHIND_M: Final = 1.0


class Spot(NamedTuple):
    """A place in the plan.

    Attributes:
        x: Metres.
        y: Metres.
        yaw: Degrees, counter-clockwise from above.
    """

    x: float
    y: float
    yaw: float


def snapped(room: Surroundings, spot: Spot, low: Array, high: Array) -> Spot:
    """The place of a box that stands on the floor.

    Args:
        room: What it stands in.
        spot: Where somebody has put its origin.
        low: (2,) its least x and y in its own frame, metres.
        high: (2,) its greatest.
    """
    faces = room.faces
    if not len(faces):
        return spot
    yaw = _parallel(faces, spot)
    corners = _corners(low, high) @ in_plan(np.radians(yaw)).T
    place = np.array([spot.x, spot.y])
    # A box in a corner comes to both walls; the second pass sees where the first has put it.
    for start, end in (*faces, *faces):
        place = place + _to_wall(start, end, place, corners)
    return Spot(float(place[0]), float(place[1]), yaw)


def hung(room: Surroundings, spot: Spot, low: Array, high: Array) -> Spot:
    """The place of a box that hangs with its back on the nearest wall."""
    if not len(room.faces):
        return spot
    width, depth = (high - low).tolist()
    found = room.hang(spot.x, spot.y, width, depth)
    # The origin of what hangs need not be the middle of its box.
    off = in_plan(np.radians(found.yaw)) @ (0.5 * (low + high))
    return Spot(found.x - float(off[0]), found.y - float(off[1]), found.yaw)


def _corners(low: Array, high: Array) -> Array:
    return np.array([(x, y) for x in (low[0], high[0]) for y in (low[1], high[1])])


def _parallel(faces: Array, spot: Spot) -> float:
    """The heading, along the nearest wall or square to it where it nearly is."""
    starts, steps = faces[:, 0], faces[:, 1] - faces[:, 0]
    lengths = np.linalg.norm(steps, axis=1)
    offsets = np.array([spot.x, spot.y]) - starts
    along = np.clip((offsets * steps).sum(axis=1) / lengths**2, 0.0, 1.0)
    gaps = np.linalg.norm(offsets - along[:, None] * steps, axis=1)
    x, y = steps[int(np.argmin(gaps))].tolist()
    off = (spot.yaw - float(np.degrees(np.arctan2(y, x))) + 45.0) % 90.0 - 45.0
    return round(spot.yaw - off, 6) if abs(off) <= TURN_DEG else spot.yaw


def _to_wall(start: Array, end: Array, place: Array, corners: Array) -> Array:
    """(2,) the step that brings a box flush to a wall; none where the wall is elsewhere."""
    step = end - start
    length = float(np.linalg.norm(step))
    ahead = step / length
    inward = np.array([-ahead[1], ahead[0]])
    reached = (place + corners - start) @ ahead
    gap = float(((place + corners - start) @ inward).min())
    beside = reached.max() <= 0.0 or reached.min() >= length
    behind = float((place - start) @ inward) < -_BEHIND_M
    if beside or behind or gap > REACH_M:
        return np.zeros(2)
    return np.asarray(-gap * inward)
