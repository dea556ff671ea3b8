"""A room's shell as the two meshes of a layout, with their materials."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Usd

from openrooms_usd import atomic, names
from openrooms_usd.arrays import Array
from openrooms_usd.errors import StageError
from openrooms_usd.geometry.triangulation import triangulate
from openrooms_usd.rendering.scene.arrays import Patch, Scene
from openrooms_usd.usd.light.emitters import world_from_prim
from orusd_openrooms.scenes.materials import Materials, losses, mapping
from orusd_openrooms.scenes.modelfiles import Faces, obj_bytes
from orusd_openrooms.scenes.objects import SHELL, Objects
from orusd_openrooms.scenes.records import Bsdf, ShapeRecord, Step

_LEAST_THICKNESS_M = 0.01
# How far an opening's middle may lie from the side that it is cut into, metres.
_REACH_M: Final = 0.3
_LEAST_M: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Opening:
    """A rectangle that is cut into the walls.

    Attributes:
        center: (3,) metres.
        along: (3,) unit vector along its width.
        width: Metres.
        height: Metres.
    """

    center: Array
    along: Array
    width: float
    height: float


def shell_faces(
    floor: Array,
    bottom: float,
    top: float,
    openings: Sequence[Opening],
    materials: Mapping[str, tuple[str, Array]],
) -> list[Faces]:
    """The faces of a shell, which look inwards; the ceiling's look up, as in the release.

    Args:
        floor: (N, 2) corners, counter-clockwise.
        bottom: Height of the floor, metres.
        top: Height of the ceiling.
        openings: What is cut into the walls.
        materials: By ``wall``, ``ceiling`` and ``floor``: the name, and the (3, 3) way from metres
            on the face to its texture coordinates.
    """
    walls = [
        quad
        for start, end in zip(floor, np.roll(floor, -1, axis=0), strict=True)
        for quad in _wall(start, end, bottom, top, openings)
    ]
    level = np.column_stack([floor, np.full(len(floor), bottom)])
    indices = np.arange(len(floor), dtype=np.int32)
    corners, _ = triangulate(level, np.array([len(floor)], dtype=np.int32), indices)
    below = level[corners]
    above = below + np.array([0.0, 0.0, top - bottom])
    found = {"wall": np.concatenate(walls), "ceiling": above, "floor": below}
    return [_faces(part, found[part], *materials[part]) for part in ("wall", "ceiling", "floor")]


def outside(floor: Array, thickness: float) -> Array:
    """(N, 2) the outline moved outwards, its corners kept."""
    before, after = floor - np.roll(floor, 1, axis=0), np.roll(floor, -1, axis=0) - floor
    a, b = (side / np.linalg.norm(side, axis=1, keepdims=True) for side in (before, after))
    normal_a, normal_b = (np.column_stack([side[:, 1], -side[:, 0]]) for side in (a, b))
    share = 1.0 + (normal_a * normal_b).sum(axis=1, keepdims=True)
    return np.asarray(floor + thickness * (normal_a + normal_b) / np.maximum(share, 0.1))


def _wall(
    start: Array, end: Array, bottom: float, top: float, openings: Sequence[Opening]
) -> Iterator[Array]:
    """(2, 3, 3) triangles of each rectangle that the openings leave of a wall."""
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    holes = [hole for one in openings if (hole := _hole(one, start, along, length)) is not None]
    xs = _cuts([0.0, length], [x for hole in holes for x in hole[:2]])
    zs = _cuts([bottom, top], [z for hole in holes for z in hole[2:]])
    for x0, x1 in pairwise(xs):
        for z0, z1 in pairwise(zs):
            x, z = 0.5 * (x0 + x1), 0.5 * (z0 + z1)
            if any(left < x < right and low < z < high for left, right, low, high in holes):
                continue
            a, b = start + along * x0, start + along * x1
            quad = np.array([[*a, z0], [*b, z0], [*b, z1], [*a, z1]])
            yield quad[[[0, 2, 1], [0, 3, 2]]]


def _hole(
    one: Opening, start: Array, along: Array, length: float
) -> tuple[float, float, float, float] | None:
    away = one.center[:2] - start
    across = np.array([-along[1], along[0]])
    middle = float(away @ along)
    if abs(away @ across) > _REACH_M or abs(one.along[:2] @ along) < 0.99:
        return None
    if not 0.0 < middle < length:
        return None
    low, high = one.center[2] - 0.5 * one.height, one.center[2] + 0.5 * one.height
    return middle - 0.5 * one.width, middle + 0.5 * one.width, float(low), float(high)


def _cuts(ends: list[float], inner: list[float]) -> list[float]:
    """Ascending, without those that are beyond the ends or equal."""
    low, high = ends
    kept = sorted(x for x in inner if low + _LEAST_M < x < high - _LEAST_M)
    return [low, *(x for i, x in enumerate(kept) if i == 0 or x - kept[i - 1] > _LEAST_M), high]


def _faces(part: str, corners: Array, material: str, uv: Array) -> Faces:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    if part == "wall":
        # Along the wall, and up.
        along = np.column_stack([-normals[:, 1], normals[:, 0]])
        flat = np.stack(
            [np.einsum("mij,mj->mi", corners[..., :2], along), corners[..., 2]], axis=-1
        )
    else:
        flat = corners[..., :2]
    st = flat @ uv[:2, :2].T + uv[:2, 2]
    return Faces(material, corners, np.repeat(normals[:, None], 3, axis=1), st)


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
            remedy="give a stage from orusd compose",
        )
    return corners, float(height)


def write_layout(
    stage: Usd.Stage,
    scene: Scene,
    objects: Objects,
    root: Path,
    name: str,
    materials: Materials,
    up: str,
) -> tuple[dict[str, Bsdf], list[ShapeRecord]]:
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
    shapes: list[ShapeRecord] = []
    for file, faces in (("uv_mapped.obj", inner), ("container.obj", outer)):
        path = f"layoutMesh/{name}/{file}"
        atomic.write_bytes(root / path, obj_bytes(faces))
        steps = (
            Step.scale(1.0, 1.0, 1.0),
            Step.rotate(90.0, np.array([-1.0, 0.0, 0.0])),
            Step.translate(0.0, 0.0, 0.0),
        )
        shapes.append(
            ShapeRecord(len(shapes), f"{name}_object", f"{up}{path}", steps, tuple(bsdfs))
        )
    return bsdfs, shapes


def layout_losses(objects: Objects) -> Iterator[tuple[str, str]]:
    """Prims of the shell, with what of them is lost; empty for nothing."""
    for path, patch in objects.shells.items():
        part = next(p for root, p in SHELL.items() if path == root or path.startswith(f"{root}/"))
        lost = ["its faces are thin, without reveals"] if part == "wall" else []
        if patch.surface is not objects.shell[part][1].surface:
            lost.append(f"it has the material of the other {part}s")
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
