"""The scene of a generated room without assets: what compose writes, put together in memory.

The layout is composed; furniture stands where the alignment step's own rules put it, in the forms
that the generator built. A test asks that this is what is composed.
"""

from pathlib import Path

import numpy as np
from pxr import Usd

from openrooms_usd.composing import compose_room
from openrooms_usd.description import Room, parse_room
from openrooms_usd.description.furniture import LibraryObject, ObjectList, named_objects
from openrooms_usd.furniture import FitOptions, category
from openrooms_usd.generation.rooms import Generated, named
from openrooms_usd.generation.shapes import BuiltForm, Shapes
from openrooms_usd.library.assets import Asset, Model
from openrooms_usd.steps.alignment.placement import Placement, Supports
from openrooms_usd.steps.alignment.poses import matrix_of
from openrooms_usd.steps.alignment.surroundings import surroundings
from tests.generation.scenes import Body, Form, Scene, fans, read


def assembled(text: str, shapes: Shapes, folder: Path) -> Scene:
    """The scene of a room from nothing.

    Args:
        text: Its description.
        shapes: The forms of its objects, as far as they are built.
        folder: Where its layout may be composed.
    """
    (folder / "room.yaml").write_text(text, encoding="utf-8")
    composed = compose_room(folder / "room.yaml", folder / "out", only="layout").scene
    scene = read(composed)
    room = parse_room(text)
    assert isinstance(room.furniture, ObjectList)
    known: dict[BuiltForm, Form] = {}
    placements = _placements(room, shapes)
    stands = Supports(placements, surroundings(Usd.Stage.Open(str(composed))), []).resolve()
    for (name, stand), shape in zip(stands.items(), _shapes(room, shapes), strict=True):
        if shape not in known:
            known[shape] = _form(shape)
        pose = matrix_of(stand.x, stand.y, stand.z, stand.yaw, stand.tilt)
        what = placements[name].asset.category
        scene.objects.append(Body(name, what, known[shape], pose))
    return scene


def arranged(room: Generated, shapes: Shapes) -> tuple[Scene, dict[str, str]]:
    """The objects alone of a room from nothing, as they were arranged, and what carries them."""
    known: dict[BuiltForm, Form] = {}
    scene = Scene([], [], [], [], [], room.shell.corners, room.shell.height)
    supports = {}
    for _, name, item, on in named(room.furnishing.groups):
        shape = shapes.of(item.category, item.size, item.style, item.order)
        if shape not in known:
            known[shape] = _form(shape)
        pose = matrix_of(item.x, item.y, item.z, item.yaw, item.tilt)
        scene.objects.append(Body(name, item.category, known[shape], pose))
        supports[name] = on
    return scene, supports


def _shapes(room: Room, shapes: Shapes) -> list[BuiltForm]:
    return [_shape(item, shapes) for _, item in named_objects(room.furniture.objects)]


def _shape(item: LibraryObject, shapes: Shapes) -> BuiltForm:
    order = FitOptions(item.fronts, item.cutouts)
    return shapes.of(item.category, item.size, item.style, order)


def _placements(room: Room, shapes: Shapes) -> dict[str, Placement]:
    placements = {}
    for name, item in named_objects(room.furniture.objects):
        parts = {str(i): mesh for i, mesh in enumerate(_shape(item, shapes).meshes)}
        model = Model(parts)
        x, y, *z = item.at
        spec = category(item.category)
        placements[name] = Placement(
            name,
            Asset(item.category, (), lambda model=model: model),
            item.size,
            x,
            y,
            z[0] if z else None,
            item.yaw,
            item.on or spec.support,
            relative_to=item.relative_to,
            level=spec.mount_height,
            tilt=item.tilt,
        )
    return placements


def _form(shape: BuiltForm) -> Form:
    counts = np.cumsum([0, *(len(mesh.points) for mesh in shape.meshes)])
    triangles = [
        fans(mesh.counts, mesh.indices) + first
        for mesh, first in zip(shape.meshes, counts, strict=False)
    ]
    points = np.concatenate([mesh.points for mesh in shape.meshes])
    return Form(points, np.concatenate(triangles))
