"""The objects of a stage with their meshes: what becomes a shape, and what the shell."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.pieces import part_of
from openrooms_usd.geometry.rotations import is_rotation
from openrooms_usd.rendering.scene.arrays import Patch, Scene
from openrooms_usd.rendering.scene.pictures import Picture
from openrooms_usd.rendering.scene.triangles import Triangles
from openrooms_usd.usd.light.emitters import world_from_prim
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.semantics import read_label
from orusd_openrooms.scenes.records import Color

SHELL: Final = {names.FLOOR: "floor", names.CEILING: "ceiling", names.WALLS: "wall"}
_GROUPS: Final = (names.FURNITURE, names.OPENINGS)
_SQUARE: Final = 1e-6
_SHIFT: Final = "xformOp:translate:placed"


@dataclass(eq=False)
class ObjectPart:
    """The triangles of an object that share a surface.

    Attributes:
        name: What they are.
        material: The prim that gives their surface; empty where none does.
        patch: Which surface, and what it emits.
        triangles: In the world.
    """

    name: str
    material: str
    patch: Patch
    triangles: list[Triangles] = field(default_factory=list)


@dataclass(eq=False)
class Object:
    """What stands in a room.

    Attributes:
        path: Its prim.
        category: What it is.
        world_from_object: (4, 4): a rotation, a translation and a scale along each of its axes;
            the identity where its own matrix is more than these.
        shifts: (3,) each, metres: those that the prim keeps apart, which come last.
        prototype: What others are copies of; its own path if it is not a copy.
        parts: By name and surface.
        baked: Why its matrix went into its mesh; empty where it did not.
    """

    path: str
    category: str
    world_from_object: Array
    shifts: tuple[Array, ...]
    prototype: str
    parts: dict[tuple[str, int], ObjectPart] = field(default_factory=dict)
    baked: str = ""

    @property
    def name(self) -> str:
        """Of its prim."""
        return self.path.rpartition("/")[2].replace("[", "_").replace("]", "")

    @property
    def bounds(self) -> Array:
        """(2, 3) least and greatest coordinates in the world."""
        corners = [own.corners for part in self.parts.values() for own in part.triangles]
        points = np.concatenate(corners).reshape(-1, 3)
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @property
    def radiance(self) -> Color | None:
        """The mean of what its parts emit, by area; None where none does."""
        lit = [part for part in self.parts.values() if part.patch.radiance is not None]
        if not lit:
            return None
        areas = np.array([_area(part) for part in lit])
        shone = np.array([_emitted(part.patch) for part in lit])
        r, g, b = (areas @ shone / max(areas.sum(), 1e-12)).tolist()
        return r, g, b


@dataclass(frozen=True, eq=False)
class Objects:
    """All surfaces of a scene, sorted.

    Attributes:
        members: In the order of the stage.
        shell: A surface for ``floor``, ``ceiling`` and ``wall`` with the prim that gives it.
        shells: The prims of the shell, with what each wears.
    """

    members: tuple[Object, ...]
    shell: Mapping[str, tuple[str, Patch]]
    shells: Mapping[str, Patch]


def objects_of(stage: Usd.Stage, scene: Scene) -> Objects:
    """Sort the surfaces of a scene by the objects that they belong to."""
    members: dict[str, Object] = {}
    shell: dict[str, tuple[str, Patch]] = {}
    shells: dict[str, Patch] = {}
    for patch in scene.patches:
        for row in np.unique(patch.triangles.pieces):
            piece = scene.pieces[row]
            path = scene.legend.part[piece.part]
            material = scene.legend.material.get(piece.material, "")
            part = _shell_part(stage, path)
            if part is not None:
                shell.setdefault(part, (material, patch))
                shells[path] = patch
                continue
            root = _root(path)
            if root not in members:
                members[root] = _object(stage, root)
            item = members[root]
            name = names.LIGHT_BULB if patch.radiance is not None else _name(path)
            own = item.parts.setdefault((name, id(patch)), ObjectPart(name, material, patch))
            here = np.flatnonzero(patch.triangles.pieces == row)
            own.triangles.append(patch.triangles.rows(here))
    order = sorted(members, key=lambda path: (not path.startswith(names.FURNITURE), path))
    return Objects(tuple(members[path] for path in order), shell, shells)


def _shell_part(stage: Usd.Stage, path: str) -> str | None:
    """Which part of the shell a prim is; None for what stands in the room, free walls too."""
    for root, part in SHELL.items():
        if path == root or path.startswith(f"{root}/"):
            prim = stage.GetPrimAtPath(path)
            free = prim and prim.GetAttribute(names.PARTITION_OUTLINE)
            return None if free else part
    return None


def _root(path: str) -> str:
    """The object that a mesh belongs to: what stands directly in a group, or the mesh itself."""
    group = next((group for group in _GROUPS if path.startswith(f"{group}/")), None)
    if group is None:
        return path
    return f"{group}/{path.removeprefix(f'{group}/').partition('/')[0]}"


def _name(path: str) -> str:
    return part_of(path.rpartition("/")[2].partition("[")[0])


def _object(stage: Usd.Stage, path: str) -> Object:
    # What a point instancer scatters has no prim of its own.
    prim = stage.GetPrimAtPath(path) if "[" not in path else None
    if not prim:
        return Object(path, "object", np.eye(4), (), path, baked="it is scattered")
    category = read_label(prim, names.CATEGORY) or "object"
    matrix = world_from_prim(prim)
    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    prototype = str(prim.GetPrototype().GetPath()) if prim.IsInstance() else path
    if not is_rotation(matrix[:3, :3] / np.maximum(scale, 1e-12), _SQUARE):
        return Object(path, category, np.eye(4), (), path, baked="it is sheared or mirrored")
    return Object(path, category, matrix, _shifts(prim), prototype)


def _shifts(prim: Usd.Prim) -> tuple[Array, ...]:
    """The shifts of their own that an object of a room has, the first of them first."""
    operations = UsdGeom.Xformable(prim).GetOrderedXformOps()
    found: list[Array] = []
    for operation in operations:
        name = operation.GetOpName()
        if name != _SHIFT and not name.startswith(f"{_SHIFT}_"):
            break
        found.append(np.array(operation.Get(TIME), dtype=np.float64))
    return tuple(reversed(found))


def _area(part: ObjectPart) -> float:
    corners = np.concatenate([one.corners for one in part.triangles])
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return float(0.5 * np.linalg.norm(np.cross(a, b), axis=1).sum())


def _emitted(patch: Patch) -> Array:
    """(3,) nits; the mean of a picture."""
    value = patch.radiance
    if isinstance(value, Picture):
        return np.asarray(value.pixels.reshape(-1, value.channels).mean(axis=0) * np.ones(3))
    return np.broadcast_to(np.asarray(value, dtype=np.float64), (3,))
