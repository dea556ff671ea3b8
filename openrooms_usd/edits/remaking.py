"""Another model in the place of an object: of any category and style of the library.

The object keeps its path and its place, so that what speaks about it, stands on it or is relative
to it still finds it. Model and look lie in ``layers/edits``; the edits alone refer to both,
and what earlier layers refer to counts no more.
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.description.furniture import SURFACES, FileObject, LibraryObject, ObjectList
from openrooms_usd.description.room import room_of
from openrooms_usd.edits.arranging import Standing, free_path, standing
from openrooms_usd.edits.assigning import context_of
from openrooms_usd.edits.editing import editing
from openrooms_usd.edits.targets import furniture
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES, category, check, styles
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.library.assets import Asset, publish
from openrooms_usd.steps.alignment.catalogue import Catalogue
from openrooms_usd.steps.alignment.placement import (
    FLOOR,
    SURFACE,
    Placement,
    ResolvedPose,
    Supports,
)
from openrooms_usd.steps.alignment.poses import author_described
from openrooms_usd.steps.alignment.step import ASSETS, placement_of
from openrooms_usd.steps.alignment.surroundings import RoomGeometry, surroundings
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.materials.dressing import Chooser, MaterialAssigner
from openrooms_usd.steps.materials.looks import publish_look
from openrooms_usd.steps.materials.palette import Palette
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.places.placements import author_placed
from openrooms_usd.usd.semantics import label, read_label
from openrooms_usd.usd.shapes.meshes import read_meshes, world_triangles

_DIGITS: Final = 4


def choices(kind: str, size: Sequence[float]) -> tuple[str, ...]:
    """The styles in which the library makes a category in about this size; none of others."""
    if kind not in CATEGORIES:
        return ()
    width, depth, height = size
    return styles(kind, (width, depth, height))


def remake(
    scene: Path, name: str, style: str, kind: str | None = None, *, keep_size: bool = True
) -> Standing:
    """Let the library make an object anew.

    Args:
        scene: The ``scene.usda`` of the room.
        name: The object.
        style: One of the category's styles.
        kind: Its category; None for what it is.
        keep_size: Whether it is as large as before, or as large as such a thing usually is.

    Raises:
        InputError: There is no such object, category or style, or this is not a composed room.
        OutputError: The edits or a model cannot be written.
        StageError: The room would not compose.
    """
    with editing(scene) as stage:
        prim = furniture(stage, name)
        wanted = kind or read_label(prim, names.CATEGORY) or ""
        known = category(wanted)
        check(wanted, known.size, style)
        usual = known.styles[style].size or known.size
        width, depth, height = standing(prim).size if keep_size else usual
        size = (round(width, _DIGITS), round(depth, _DIGITS), round(height, _DIGITS))
        context = context_of(stage, scene)
        asset = Catalogue(context).furniture(wanted, size, style)
        layer = stage.GetEditTarget().GetLayer()
        spec = Sdf.CreatePrimInLayer(layer, prim.GetPath())
        # What was edited of the parts of the old model finds them no more.
        for child in list(spec.nameChildren):
            del spec.nameChildren[child.name]
        # The place of a copy is in part that of its original, which it refers to no more.
        local = UsdGeom.Xformable(prim).GetLocalTransformation(TIME)
        give_model(context, spec, prim, asset)
        spec.instanceable = not known.emits
        label(prim, wanted)
        _unscale(spec, prim, local)
        return standing(prim)


def give_model(context: StepContext, spec: Sdf.PrimSpec, prim: Usd.Prim, asset: Asset) -> None:
    """Let an object refer to a model and to a look for it, both beside the edits.

    Args:
        context: As `openrooms_usd.edits.assigning.context_of` has it.
        spec: The object in the edits.
        prim: The same in the composed stage.
        asset: Published where it is not there yet.

    Raises:
        OutputError: A file cannot be written.
    """
    model = context.asset(f"{ASSETS}/{publish(context.folder / ASSETS, asset)}")
    _refer(spec, [model])
    _refer(spec, [*_look(context, prim), model])


def _refer(spec: Sdf.PrimSpec, files: Sequence[str]) -> None:
    """Refer to these files alone; of an object of the edits, beside the body that physics gives."""
    references = [Sdf.Reference(file) for file in files]
    if spec.specifier == Sdf.SpecifierDef:
        spec.referenceList.ClearEdits()
        spec.referenceList.prependedItems = references
    else:
        spec.referenceList.ClearEditsAndMakeExplicit()
        spec.referenceList.explicitItems = references


def _look(context: StepContext, prim: Usd.Prim) -> list[str]:
    """A look for the model as the tables have it; none for one that brings its own materials."""
    look = MaterialAssigner(context, (Chooser(context),), {}).dressed(prim)
    if not look.looks[0]:
        return []
    palette = Palette(context)
    palette.publish(look.looks[0].values())
    return [publish_look(context, palette, look)]


def _unscale(spec: Sdf.PrimSpec, prim: Usd.Prim, local: Gf.Matrix4d) -> None:
    """Keep the place without its scale: the model is made in its size."""
    scale = np.linalg.norm(np.array(local)[:3, :3], axis=1)
    author_placed(spec, prim, Gf.Matrix4d().SetScale(Gf.Vec3d(*(1.0 / scale).tolist())) * local)


# New objects in a composed room: of the library or of a file, as opinions in the edits.

Described: TypeAlias = LibraryObject | FileObject

_LOG: Final = logging.getLogger("openrooms_usd")
# From where tops are looked for, metres above the floor.
_ABOVE_M: Final = 100.0


def add(scene: Path, said: Mapping[str, Any], base: Path | None = None) -> Standing:
    """Put a new object into a room.

    Args:
        scene: The ``scene.usda`` of the room.
        said: The object as ``furniture: objects:`` of a room.yaml has it. What carries it, and what
            it is relative to, are objects of the room.
        base: Where the name of its file begins; None for the scene's folder.

    Raises:
        DescriptionError: It is not a valid object; the message is that of compose.
        InputError: There is no such style or support, its file cannot be read, or this is not a
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
        # The lights step writes over bulbs, which it could not inside an instance.
        spec.instanceable = not wanted.emits
        for note in context.notes:
            _LOG.warning("%s", note)
        return standing(prim)


def _described(said: Mapping[str, Any]) -> Described:
    """The object, checked as those of a room.yaml are; what it refers to is looked for later."""
    alone = {key: said[key] for key in said if key not in ("on", "relative_to")}
    section = room_of({"furniture": {"objects": [alone]}}).furniture
    assert isinstance(section, ObjectList), "it was given"
    return section.objects[0]


def _path(stage: Usd.Stage, item: Described) -> Sdf.Path:
    """Where the object goes: a name of its own, which the description does not number into."""
    path = Sdf.Path(names.FURNITURE).AppendChild(item.name or f"{item.category}_added")
    if item.name and stage.GetPrimAtPath(path):
        raise InputError(
            f"an object {item.name!r} already exists", place=path, remedy="choose another name"
        )
    return free_path(stage, path)


def _stand(
    stage: Usd.Stage, item: Placement, on: str | None, relative_to: str | None, notes: list[str]
) -> ResolvedPose:
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
    return Supports({item.name: item}, room, notes).resolve()[item.name]


def _top(stage: Usd.Stage, room: RoomGeometry, item: Placement, on: str | None) -> float:
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
