"""A room's shell as the two meshes of a layout, with their materials."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from openrooms_usd import atomic, names
from openrooms_usd.errors import StageError
from openrooms_usd.render.scene.arrays import Patch, Scene
from openrooms_usd.usd.emitters import world_from_prim
from orusd_openrooms.scenes.microfacet import Materials, losses, mapping
from orusd_openrooms.scenes.objects import SHELL, Objects
from orusd_openrooms.scenes.objtext import obj_bytes
from orusd_openrooms.scenes.records import Bsdf, Shape, Step
from orusd_openrooms.scenes.thinshell import Opening, outside, shell_faces

Array = NDArray[np.float64]

_LEAST_THICKNESS_M = 0.01


def floor_of(stage: Usd.Stage) -> tuple[Array, float]:
    """The floor's (N, 2) corners, counter-clockwise, and the height of the room, metres.

    Raises:
        StageError: The stage has no room.
    """
    prim = stage.GetPrimAtPath(names.ROOM)
    floor, height = (
        prim.GetAttribute(name).Get() if prim and prim.GetAttribute(name) else None
        for name in (names.ROOM_FLOOR, "openrooms:room:height")
    )
    corners = np.array(floor if floor is not None else [], dtype=np.float64)
    known = corners.ndim == 2 and len(corners) >= 3 and bool(np.isfinite(corners).all())
    if not known or not height or not 0.0 < height < np.inf:
        raise StageError(
            "the stage has no room whose floor and height are known",
            place=names.ROOM,
            remedy="give a stage that orusd compose has made",
        )
    return corners, float(height)


def write_layout(
    stage: Usd.Stage, scene: Scene, objects: Objects, root: Path, name: str,
    materials: Materials, up: str,
) -> tuple[dict[str, Bsdf], list[Shape]]:  # fmt: skip
    """Write ``uv_mapped.obj`` and ``container.obj``.

    Args:
        stage: The composed stage.
        scene: The same as arrays.
        objects: Its surfaces, sorted.
        root: The dataset's folder.
        name: Of the scene.
        materials: Writes the maps.
        up: The way from a scene file to the dataset's folder.

    Returns:
        Their materials, and their shapes.

    Raises:
        StageError: The stage has no room.
        OutputError: A file cannot be written.
    """
    floor, height = floor_of(stage)
    openings = list(_openings(stage))
    bsdfs, worn = {}, {}
    for part in ("wall", "ceiling", "floor"):
        identifier, uv = f"{name}_{part}", np.eye(3)
        bsdfs[identifier] = Bsdf(identifier)
        if part in objects.shell:
            material, patch = objects.shell[part]
            bsdfs[identifier] = materials.bsdf(identifier, patch.surface, material)
            uv = mapping(patch.surface) @ patch.surface.uv
        worn[part] = identifier, uv
    thickness = _thickness(scene, objects)
    around = outside(floor, thickness)
    inner = shell_faces(floor, 0.0, height, openings, worn)
    outer = shell_faces(around, -thickness, height + thickness, openings, worn)
    shapes: list[Shape] = []
    for file, faces in (("uv_mapped.obj", inner), ("container.obj", outer)):
        path = f"layoutMesh/{name}/{file}"
        atomic.write_bytes(root / path, obj_bytes(faces))
        steps = (
            Step.scale(1.0, 1.0, 1.0),
            Step.rotate(90.0, np.array([-1.0, 0.0, 0.0])),
            Step.translate(0.0, 0.0, 0.0),
        )
        shapes.append(Shape(len(shapes), f"{name}_object", f"{up}{path}", steps, tuple(bsdfs)))
    return bsdfs, shapes


def layout_losses(objects: Objects) -> Iterator[tuple[str, str]]:
    """Prims of the shell, with what of them is lost; empty for nothing."""
    for path, patch in objects.shells.items():
        part = next(p for root, p in SHELL.items() if path == root or path.startswith(f"{root}/"))
        lost = ["its faces are thin, without reveals"] if part == "wall" else []
        if patch.surface is not objects.shell[part][1].surface:
            lost.append(f"it wears the material of the other {part}s")
        yield path, "; ".join(filter(None, (*lost, losses(patch.surface))))


def _thickness(scene: Scene, objects: Objects) -> float:
    """Of the walls and slabs: how far the floor's mesh reaches down."""
    patches: Mapping[int, Patch] = {id(patch): patch for patch in objects.shells.values()}
    low = [
        float(patch.triangles.rows(patch.triangles.pieces == row).corners[..., 2].min())
        for patch in patches.values()
        for row in np.unique(patch.triangles.pieces)
        if scene.legend.part[scene.pieces[row].part].startswith(names.FLOOR)
    ]
    return max(-min(low, default=0.0), _LEAST_THICKNESS_M)


def _openings(stage: Usd.Stage) -> Iterator[Opening]:
    group = stage.GetPrimAtPath(names.OPENINGS)
    for prim in group.GetChildren() if group else ():
        width, height = (
            prim.GetAttribute(name).Get() for name in (names.OPENING_WIDTH, names.OPENING_HEIGHT)
        )
        if width and height:
            M = world_from_prim(prim)
            along = M[:3, 0] / np.linalg.norm(M[:3, 0])
            yield Opening(M[:3, 3], along, float(width), float(height))
