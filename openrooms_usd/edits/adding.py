"""New objects in a composed room: of the library or of a file, as opinions in the edits."""

import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
from pxr import Kind, Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.description.alignment import SURFACES, FileObject, LibraryObject, ObjectList
from openrooms_usd.description.room import room_of
from openrooms_usd.edits.arranging import Standing, free_path, standing
from openrooms_usd.edits.assigning import context_of
from openrooms_usd.edits.editing import editing
from openrooms_usd.edits.remaking import give_model
from openrooms_usd.edits.targets import furniture
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.stages.alignment.catalogue import Catalogue
from openrooms_usd.stages.alignment.placement import FLOOR, SURFACE, Placement, Stand, Supports
from openrooms_usd.stages.alignment.poses import author_described
from openrooms_usd.stages.alignment.stage import placement_of
from openrooms_usd.stages.alignment.surroundings import Surroundings, surroundings
from openrooms_usd.usd.shapes.meshes import read_meshes, world_triangles

Described: TypeAlias = LibraryObject | FileObject

_LOG: Final = logging.getLogger("openrooms_usd")
# From where tops are looked for, metres above the floor.
_ABOVE_M: Final = 100.0


def add(scene: Path, said: Mapping[str, Any], base: Path | None = None) -> Standing:
    """Put a new object into a room.

    Args:
        scene: The ``scene.usda`` of the room.
        said: The object as ``alignment: objects:`` of a room.yaml has it. What carries it, and what
            it is relative to, are objects of the room.
        base: Where the name of its file begins; None for the scene's folder.

    Raises:
        DescriptionError: It is no object, in the words that compose would use.
        InputError: There is no such style or support, its file cannot be read, or this is no
            composed room.
        OutputError: The edits or its model cannot be written.
        StageError: The room would not compose, or has nothing to hang it from.
    """
    item = _described(said)
    with editing(scene) as stage:
        path = _path(stage, item)
        context = context_of(stage, scene, base)
        wanted = placement_of(Catalogue(context), path.name, item)
        stand = _stand(stage, wanted, said.get("on"), said.get("relative_to"), context.notes)
        spec = Sdf.CreatePrimInLayer(stage.GetEditTarget().GetLayer(), path)
        spec.specifier, spec.typeName = Sdf.SpecifierDef, "Xform"
        spec.SetInfo("kind", Kind.Tokens.component)
        author_described(spec, stand.x, stand.y, stand.z, stand.yaw, stand.tilt)
        prim = stage.GetPrimAtPath(path)
        give_model(context, spec, prim, wanted.asset)
        # The lights stage writes over bulbs, which it could not inside an instance.
        spec.instanceable = not wanted.emits
        for note in context.notes:
            _LOG.warning("%s", note)
        return standing(prim)


def _described(said: Mapping[str, Any]) -> Described:
    """The object, checked as those of a room.yaml are; what it refers to is looked for later."""
    alone = {key: said[key] for key in said if key not in ("on", "relative_to")}
    section = room_of({"alignment": {"objects": [alone]}}).alignment
    assert isinstance(section, ObjectList), "it was given"
    return section.objects[0]


def _path(stage: Usd.Stage, item: Described) -> Sdf.Path:
    """Where the object goes: a name of its own, which the description does not number into."""
    path = Sdf.Path(names.FURNITURE).AppendChild(item.name or f"{item.category}_added")
    if item.name and stage.GetPrimAtPath(path):
        raise InputError(
            f"there is an object {item.name!r} already", place=path, remedy="name it otherwise"
        )
    return free_path(stage, path)


def _stand(
    stage: Usd.Stage, item: Placement, on: str | None, relative_to: str | None, notes: list[str]
) -> Stand:
    """Where it stands, on what is composed."""
    room = surroundings(stage)
    if relative_to is not None:
        frame = standing(furniture(stage, relative_to))
        x, y = (in_plan(np.radians(frame.yaw)) @ [item.x, item.y] + [frame.x, frame.y]).tolist()
        item = replace(item, x=x, y=y, yaw=item.yaw + frame.yaw)
    if on in SURFACES:
        item = replace(item, on=on)
    elif on is not None or item.on == SURFACE:
        z = _top(stage, room, item, on) + item.lift if item.z is None else item.z
        item = replace(item, on=FLOOR, z=z)
    return Supports({item.name: item}, room, notes).stands()[item.name]


def _top(stage: Usd.Stage, room: Surroundings, item: Placement, on: str | None) -> float:
    """Height of what is below a place: of one object, or of all that stands on the floor."""
    group = stage.GetPrimAtPath(names.FURNITURE)
    every = [child for child in group.GetChildren() if UsdGeom.Xformable(child)] if group else []
    carriers = [furniture(stage, on)] if on else every
    paths = tuple(
        f"{prim.GetPath()}/" for prim in carriers if standing(prim).support == FLOOR or on
    )
    meshes = [mesh for mesh in read_meshes(stage, bare=True) if mesh.path.startswith(paths)]
    points, triangles, _ = world_triangles(meshes)
    above = room.floor + _ABOVE_M
    hits = RayCaster(points, triangles).first_hit([[item.x, item.y, above]], [[0.0, 0.0, -1.0]])
    if hits.hit[0]:
        return above - float(hits.distance[0])
    if on and len(points):
        raise InputError(
            f"{on} is not below ({item.x:g}, {item.y:g})",
            place=f"{names.FURNITURE}/{on}",
            remedy="choose a place on it, or give z",
        )
    return room.floor
