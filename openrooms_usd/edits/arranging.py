"""Furniture of a composed room, as people change it: where it stands, and what it is.

Everything is an opinion in the edits: operations of a transform, labels, a reference to another
model in ``layers/edits/assets``, a copy that refers to the original, a prim that is not active.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.edits.editing import editing
from openrooms_usd.edits.snapping import PlanPoint, hung, snapped
from openrooms_usd.edits.targets import all_furniture, furniture
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.steps.alignment.surroundings import RoomGeometry, surroundings
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.places.placements import author_placed
from openrooms_usd.usd.semantics import label, read_label

# Between an object and its copy, metres; how far copies go to stand free, and in what steps.
_APART_M: Final = 0.05
_FAR_M: Final = 4.0
_STEP_M: Final = 0.25
# Flush to a wall still counts as inside the room, metres; thinner things, such as rugs, are not
# obstacles.
_FLUSH_M: Final = 1e-3
_THIN_M: Final = 0.03
# What is that near to the floor stands on it, metres.
_ON_FLOOR_M: Final = 0.1

_SNAPS: Final[dict[str, Callable[..., PlanPoint]]] = {"floor": snapped, "wall": hung}


@dataclass(frozen=True)
class Standing:
    """An object as it stands.

    Attributes:
        name: Its name.
        category: What it is; empty if unknown.
        support: What usually carries such a thing: floor, wall, ceiling or surface.
        x: Of its origin, metres.
        y: Of its origin, metres.
        z: Of its origin, metres.
        yaw: Degrees, counter-clockwise from above.
        size: Width, depth and height, metres.
        low: Least x and y of its box in its own frame, scaled, metres.
        high: Greatest x and y.
        bottom: Least z, metres.
    """

    name: str
    category: str
    support: str
    x: float
    y: float
    z: float
    yaw: float
    size: tuple[float, float, float]
    low: tuple[float, float]
    high: tuple[float, float]
    bottom: float = 0.0


def standing(prim: Usd.Prim) -> Standing:
    """Where an object stands, in the frame of all furniture."""
    local = UsdGeom.Xformable(prim).GetLocalTransformation(TIME)
    rows = np.array(local)
    scale = np.linalg.norm(rows[:3, :3], axis=1)
    boxes = UsdGeom.BBoxCache(TIME, [UsdGeom.Tokens.default_], useExtentsHint=True)
    box = boxes.ComputeUntransformedBound(prim).ComputeAlignedRange()
    empty = box.IsEmpty()
    low, high = (np.zeros(3) if empty else np.array(end) * scale for end in (box.min, box.max))
    category = read_label(prim, names.CATEGORY) or ""
    known = CATEGORIES.get(category)
    x, y, z = rows[3, :3].tolist()
    return Standing(
        prim.GetName(),
        category,
        known.support if known else "floor",
        x,
        y,
        z,
        float(np.degrees(np.arctan2(rows[0, 1], rows[0, 0]))),
        tuple((high - low).tolist()),
        tuple(low[:2].tolist()),
        tuple(high[:2].tolist()),
        float(low[2]),
    )


def resized(thing: Standing, size: tuple[float, float, float]) -> Standing:
    """An object as it would be with another size."""
    across, along, _ = np.array(size) / np.maximum(thing.size, 1e-9)
    (x0, y0), (x1, y1) = thing.low, thing.high
    low, high = (x0 * across, y0 * along), (x1 * across, y1 * along)
    return replace(thing, size=size, low=low, high=high)


def settled(room: RoomGeometry, thing: Standing, spot: PlanPoint) -> PlanPoint:
    """Where an object comes to stand that is put somewhere: snapped as its kind is."""
    snap = _SNAPS.get(thing.support)
    stacked = thing.support == "floor" and thing.z > room.floor + _ON_FLOOR_M
    return (
        spot
        if snap is None or stacked
        else snap(room, spot, *map(np.array, (thing.low, thing.high)))
    )


def place(
    scene: Path,
    name: str,
    spot: PlanPoint,
    *,
    z: float | None = None,
    size: tuple[float, float, float] | None = None,
    snap: bool = True,
) -> Standing:
    """Move, turn or resize an object.

    Args:
        scene: The ``scene.usda`` of the room.
        name: The object.
        spot: Where its origin shall be.
        z: Height of its origin, metres; None: as it is, but that what stands on the floor does so
            wherever it is snapped to.
        size: Its width, depth and height, metres; None: as they are.
        snap: Whether it comes flush to walls that are near.

    Raises:
        InputError: There is no such object, or this is not a composed room.
        OutputError: The edits cannot be written.
        StageError: The room would not compose.
    """
    with editing(scene) as stage:
        prim, room = furniture(stage, name), surroundings(stage)
        if size is not None:
            _write(stage, prim, _resized(prim, size))
        thing = standing(prim)
        goal = settled(room, thing, spot) if snap else spot
        floored = thing.support == "floor" and abs(thing.z - room.floor) < _ON_FLOOR_M
        usual = room.floor if floored and snap else thing.z
        _write(stage, prim, _transform_at(prim, goal, usual if z is None else z))
        return standing(prim)


def duplicate(scene: Path, name: str) -> Standing:
    """Put a copy of an object beside it, to its right.

    The copy refers to the original: it has its model, materials, labels and body, and follows
    when they change.

    Raises:
        InputError: There is no such object, or this is not a composed room.
        OutputError: The edits cannot be written.
        StageError: The room would not compose.
    """
    with editing(scene) as stage:
        original = furniture(stage, name)
        thing = standing(original)
        spot = beside(stage, thing)
        path = free_path(stage, original.GetPath().ReplaceName(f"{name}_copy"))
        layer = stage.GetEditTarget().GetLayer()
        spec = Sdf.CreatePrimInLayer(layer, path)
        spec.specifier, spec.typeName = Sdf.SpecifierDef, original.GetTypeName()
        spec.referenceList.Prepend(Sdf.Reference("", original.GetPath()))
        spec.instanceable = original.IsInstanceable()
        # Also when the original is taken away.
        spec.active = True
        copy = stage.GetPrimAtPath(path)
        _write(stage, copy, _transform_at(copy, spot, thing.z))
        return standing(copy)


def remove(scene: Path, name: str) -> None:
    """Take an object away: it is switched off, and comes back when the opinion is removed.

    Raises:
        InputError: There is no such object, or this is not a composed room.
        OutputError: The edits cannot be written.
        StageError: The room would not compose.
    """
    with editing(scene) as stage:
        furniture(stage, name).SetActive(False)


def relabel(scene: Path, name: str, category: str) -> Standing:
    """Call an object something else; its mesh stays.

    Args:
        scene: The ``scene.usda`` of the room.
        name: The object.
        category: What it is.

    Raises:
        DescriptionError: There is no such category, in the words that compose would use.
        InputError: There is no such object, or this is not a composed room.
        OutputError: The edits cannot be written.
        StageError: The room would not compose.
    """
    from openrooms_usd.description.room import room_of

    room_of({"furniture": {"objects": [{"category": category, "at": [0.0, 0.0]}]}})
    with editing(scene) as stage:
        prim = furniture(stage, name)
        label(prim, category)
        return standing(prim)


def beside(stage: Usd.Stage, thing: Standing) -> PlanPoint:
    """A free place next to an object: to its right, or where walls and others leave room.

    Args:
        stage: The composed room.
        thing: The object.

    Returns:
        The nearest place where it is inside of the walls and in no other's box; where there is
        none, the one beside it that walls leave most room.
    """
    import shapely

    room, others = surroundings(stage), [standing(prim) for prim in all_furniture(stage)]
    here, width, depth = np.array([thing.x, thing.y]), *thing.size[:2]
    taken = [_footprint(each) for each in others if _share_heights(thing, each)]
    walls = shapely.Polygon(room.walls[:, 0]).buffer(_FLUSH_M) if len(room.walls) > 2 else None
    found = []
    for more in np.arange(0.0, _FAR_M, _STEP_M):
        for turn, side in ((0.0, width), (180.0, width), (-90.0, depth), (90.0, depth)):
            way = in_plan(np.radians(thing.yaw + turn))[:, 0] * (side + _APART_M + more)
            x, y = (here + way).tolist()
            spot = settled(room, thing, PlanPoint(x, y, thing.yaw))
            apart = float(np.linalg.norm(np.array([spot.x, spot.y]) - here)) - side
            box = _footprint(replace(thing, x=spot.x, y=spot.y, yaw=spot.yaw))
            free = (walls is None or walls.covers(box)) and not any(map(box.intersects, taken))
            if apart >= 0.0 and free:
                return spot
            found.append((apart, spot))
    return max(found[:4])[1]


def _footprint(thing: Standing) -> Any:
    """Its box from above, a polygon of shapely."""
    import shapely

    (x0, y0), (x1, y1) = thing.low, thing.high
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    turned = corners @ in_plan(np.radians(thing.yaw)).T + [thing.x, thing.y]
    return shapely.Polygon(turned)


def _share_heights(one: Standing, other: Standing) -> bool:
    """Whether two things can be in each other's way: rugs and what hangs above cannot."""
    low = max(each.z + each.bottom for each in (one, other))
    high = min(each.z + each.bottom + each.size[2] for each in (one, other))
    return high - low > _THIN_M


def free_path(stage: Usd.Stage, path: Sdf.Path) -> Sdf.Path:
    """A path that the room does not have: this one, or with a number where it is taken."""
    numbered = (path.ReplaceName(f"{path.name}_{number}") for number in count(2))
    return next(one for one in chain([path], numbered) if not stage.GetPrimAtPath(one))


def _transform_at(prim: Usd.Prim, spot: PlanPoint, z: float) -> Gf.Matrix4d:
    """An object's transform at another place; it leans and is scaled as before."""
    local = UsdGeom.Xformable(prim).GetLocalTransformation(TIME)
    turn = Gf.Rotation(Gf.Vec3d.ZAxis(), spot.yaw - standing(prim).yaw)
    moved = local * Gf.Matrix4d().SetRotate(turn)
    moved.SetTranslateOnly(Gf.Vec3d(spot.x, spot.y, z))
    return moved


def _resized(prim: Usd.Prim, size: tuple[float, float, float]) -> Gf.Matrix4d:
    """An object's transform with another size along its own axes."""
    local = UsdGeom.Xformable(prim).GetLocalTransformation(TIME)
    before = np.maximum(standing(prim).size, 1e-9)
    return Gf.Matrix4d().SetScale(Gf.Vec3d(*(np.array(size) / before).tolist())) * local


def _write(stage: Usd.Stage, prim: Usd.Prim, local: Gf.Matrix4d) -> None:
    spec = Sdf.CreatePrimInLayer(stage.GetEditTarget().GetLayer(), prim.GetPath())
    author_placed(spec, prim, local)
