"""Generated rooms for the scanner: what it may see, and what is true of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, NamedTuple

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from benchmarks.scan.truth import Cad, Truth, moved, pose_of
from benchmarks.scenes import orusd
from openrooms_usd import names
from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.polygons import counter_clockwise
from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.scan.results import FoundObject, FoundOpening, FoundRoom
from openrooms_usd.usd.places.frames import local_to_world, world_from_stage
from openrooms_usd.usd.semantics import read_label, read_number
from openrooms_usd.usd.shapes.meshes import PlacedMesh, read_meshes, world_triangles

OPAQUE, GLASS, MIRROR = range(3)
# Holes whose lower edge is higher than this are windows, metres.
SILL: Final = 0.3


class Part(NamedTuple):
    """Triangles that share what is known of them.

    Attributes:
        label: The NYU40 class.
        instance: The number of the object; 0 for the room itself.
        optics: ``OPAQUE``, ``GLASS`` or ``MIRROR``.
        wall: The number of the wall that they belong to, its openings included; else -1.
    """

    label: int
    instance: int
    optics: int = OPAQUE
    wall: int = -1


@dataclass(frozen=True, eq=False)
class SimulatedRoom:
    """Triangles for a scanner, and the truth; world frame, Z up, metres.

    Attributes:
        points: (N, 3) corners.
        triangles: (M, 3) rows of ``points``.
        part: (M,) which of ``parts`` each triangle belongs to.
        parts: What is known of them.
        truth: In the world frame.
    """

    points: Array
    triangles: Ints
    part: Ints
    parts: tuple[Part, ...]
    truth: Truth

    @property
    def floor(self) -> Array:
        """(P, 2) the outline of the first room."""
        return self.truth.rooms[0].corners[:, :2]


def generated(kind: str, seed: int, folder: Path) -> Path:
    """Generate and compose a room, unless the folder has it already; return its stage."""
    stage = folder / f"{kind}_{seed}" / "out" / names.SCENE
    if not stage.is_file():
        described = folder / f"{kind}_{seed}"
        orusd("generate", "--type", kind, "--seed", seed, "-o", described)
        orusd("compose", described / "room.yaml", "-o", described / "out")
    return stage


def read_room(path: Path) -> SimulatedRoom:
    """What a scanner sees of a composed room.

    Args:
        path: Its stage.
    """
    stage = Usd.Stage.Open(str(path))
    meshes = read_meshes(stage).meshes
    points, triangles, owner = world_triangles(meshes)
    cache = UsdGeom.XformCache()
    objects = stage.GetPrimAtPath(names.FURNITURE).GetChildren()
    openings = stage.GetPrimAtPath(names.OPENINGS).GetChildren()
    numbers = {str(p.GetPath()): i + 1 for i, p in enumerate([*objects, *openings])}
    parts = [_part(mesh, numbers) for mesh in meshes]
    distinct = sorted(set(parts))
    rows = np.array([distinct.index(part) for part in parts], dtype=np.int64)
    room = _room(stage, openings, cache)
    found, cads = [], {}
    for prim in objects:
        own = [mesh for mesh in meshes if mesh.path.startswith(f"{prim.GetPath()}/")]
        if own:
            item, cad = _object(prim, own, numbers[str(prim.GetPath())], cache)
            cads.setdefault(cad.id, cad)
            found.append(item)
    truth = Truth((room,), tuple(found), cads)
    return SimulatedRoom(points, triangles.astype(np.int64), rows[owner], tuple(distinct), truth)


def _part(mesh: PlacedMesh, numbers: dict[str, int]) -> Part:
    instance = next((n for path, n in numbers.items() if mesh.path.startswith(f"{path}/")), 0)
    above = mesh.prim.GetPath().GetAncestorsRange()
    stage = mesh.prim.GetStage()
    number = read_number(map(stage.GetPrimAtPath, above), names.NYU40)
    wall = mesh.prim
    if str(wall.GetPath()).startswith(names.OPENINGS):
        while not wall.HasRelationship(names.OPENING_WALL):
            wall = wall.GetParent()
        target = wall.GetRelationship(names.OPENING_WALL).GetTargets()[0]
        return Part(number, instance, _optics(mesh.prim), _wall_number(target.name))
    walled = str(wall.GetPath()).startswith(names.WALLS)
    return Part(
        number, instance, _optics(mesh.prim), _wall_number(wall.GetName()) if walled else -1
    )


def _wall_number(name: str) -> int:
    return int(name.rpartition("_")[2])


def _optics(prim: Usd.Prim) -> int:
    """Whether a mesh is of glass, or a mirror; both are of the material glass."""
    if "mirror" in (read_label(prim, names.PART) or "") or prim.GetName().startswith("mirror"):
        return MIRROR
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    category = material.GetPrim().GetAttribute(names.MATERIAL_CATEGORY) if material else None
    return GLASS if category and category.Get() == "glass" else OPAQUE


def _room(stage: Usd.Stage, openings: Sequence[Usd.Prim], cache: UsdGeom.XformCache) -> FoundRoom:
    prim = stage.GetPrimAtPath(names.ROOM)
    given = np.array(prim.GetAttribute(names.ROOM_FLOOR).Get(), dtype=np.float64)
    world = local_to_world(prim, cache)
    plan, _ = counter_clockwise(given)
    corners = moved(world, np.column_stack([plan, np.zeros(len(plan))]))
    height = float(prim.GetAttribute("openrooms:room:height").Get())
    holes = tuple(_opening(item, corners, cache) for item in openings)
    return FoundRoom(world[:3, 2], corners[0], corners, (), height, holes)


def _opening(prim: Usd.Prim, corners: Array, cache: UsdGeom.XformCache) -> FoundOpening:
    """The hole in the wall: its frame has x to the right as seen from inside, y outwards, z up."""
    width, height, sill = (
        float(prim.GetAttribute(name).Get())
        for name in (names.OPENING_WIDTH, names.OPENING_HEIGHT, "openrooms:opening:sill")
    )
    kind = str(prim.GetAttribute("openrooms:opening:kind").Get())
    x, z = width / 2, height / 2
    ring = np.array([[-x, 0, -z], [x, 0, -z], [x, 0, z], [-x, 0, z]])
    placed = moved(local_to_world(prim, cache), ring)
    window = kind == "window" or sill > SILL
    middle = placed.mean(axis=0)[:2]
    return FoundOpening("window" if window else "door", placed, 1.0, nearest_wall(corners, middle))


def nearest_wall(corners: Array, point: Array) -> int:
    """The number of the edge (from corner i to the next) that is nearest in the plan."""
    starts = corners[:, :2]
    along = np.roll(starts, -1, axis=0) - starts
    t = np.clip(((point - starts) * along).sum(axis=1) / (along**2).sum(axis=1), 0, 1)
    return int(np.linalg.norm(starts + t[:, None] * along - point, axis=1).argmin())


def _object(
    prim: Usd.Prim, meshes: Sequence[PlacedMesh], number: int, cache: UsdGeom.XformCache
) -> tuple[FoundObject, Cad]:
    world = world_from_stage(prim.GetStage()) @ local_to_world(prim, cache)
    points, faces, _ = world_triangles(meshes)
    category = read_label(prim, names.CATEGORY) or "object"
    cad = _cad(prim, category, moved(np.linalg.inv(world), points), faces.astype(np.int64))
    pose = pose_of(world)
    item = FoundObject(number, category, cad.id, pose, 0.0, 1.0, cad.symmetry, pose)
    return item, cad


def _cad(prim: Usd.Prim, category: str, vertices: Array, faces: Ints) -> Cad:
    references = prim.GetMetadata("references")
    items = references.GetAddedOrExplicitItems() if references else []
    file = Path(items[0].assetPath).stem if items else prim.GetName()
    return Cad(file, category, vertices, faces, symmetry_of(vertices, faces))


# Which turns about the vertical a model does not notice.

Symmetry = Literal["none", "2", "4", "inf"]

# A turned model counts as the same where all but this part of its surface moves by less than
# this, metres: below what depth cameras tell apart.
SHARE: Final = 0.005
DISTANCE: Final = 0.015
SAMPLES: Final = 40_000
TURNED: Final = 4000
# The turns that each symmetry allows, degrees; the odd ones stand for all angles.
TURNS: Final[tuple[tuple[Symmetry, tuple[int, ...]], ...]] = (
    ("inf", (37, 90, 143)),
    ("4", (90, 180)),
    ("2", (180,)),
)


def symmetry_of(vertices: Array, faces: Ints) -> Symmetry:
    """The symmetry about the vertical through the origin.

    Args:
        vertices: (V, 3) Z up, metres.
        faces: (F, 3) rows of ``vertices``.
    """
    from scipy.spatial import cKDTree

    samples = surface_samples(vertices, faces, SAMPLES, np.random.default_rng(0))
    surface, some = cKDTree(samples), samples[:TURNED]
    for name, angles in TURNS:
        if all(
            np.quantile(surface.query(turned(some, a))[0], 1 - SHARE) < DISTANCE for a in angles
        ):
            return name
    return "none"


def turned(points: Array, degrees: float) -> Array:
    """(N, 3) points after a turn about the vertical."""
    return np.asarray(points @ about_z(-np.radians(degrees)))


def surface_samples(vertices: Array, faces: Ints, count: int, random: np.random.Generator) -> Array:
    """(count, 3) points that are uniform on a surface."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = random.choice(len(faces), count, p=areas / areas.sum())
    u, v = random.random((2, count, 1))
    outside = u + v > 1
    u, v = np.where(outside, 1 - u, u), np.where(outside, 1 - v, v)
    return np.asarray(a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen])
