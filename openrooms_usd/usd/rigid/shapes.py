"""The shapes of a stage that collide and those that are seen, in the frames of their links."""

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.solids import sphere
from openrooms_usd.geometry.triangulation import TriangleMesh, bounding_box
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.physics.components import Part
from openrooms_usd.physics.decomposition import collision_shapes
from openrooms_usd.physics.hulls import MOST_VERTICES, convex_hull, half_spaces
from openrooms_usd.physics.world import STANDARD_GRAVITY, Contact, Shape, Visual
from openrooms_usd.usd.bodies import frame_and_scale
from openrooms_usd.usd.places.frames import TIME, matrix, meters_per_unit, world_from_stage
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.materials import bound_material, bound_subsets
from openrooms_usd.usd.shapes.gprims import read_surface
from openrooms_usd.usd.shapes.meshes import PlacedMesh

# Rigid frames of the prims of a stage, in metres with Z up.


class Frames:
    """Frames of the prims of one stage.

    Args:
        stage: The composed stage, in any unit and with any axis up.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        self.stage = stage
        self._cache = UsdGeom.XformCache(TIME)

    @cached_property
    def metres(self) -> float:
        """Metres for one unit of the stage."""
        return meters_per_unit(self.stage)

    @cached_property
    def kilograms(self) -> float:
        """Kilograms for one unit of the stage."""
        return float(UsdPhysics.GetStageKilogramsPerUnit(self.stage))

    @cached_property
    def turn(self) -> Array:
        """(3, 3) from the stage's axes to Z up."""
        return np.asarray(world_from_stage(self.stage)[:3, :3] / self.metres)

    def world(self, prim: Usd.Prim) -> Array:
        """(4, 4) from a prim's own frame, with its scale, to the world."""
        placed = matrix(self._cache.GetLocalToWorldTransform(prim))
        return np.asarray(world_from_stage(self.stage) @ placed)

    def rigid(self, path: Sdf.Path) -> Array:
        """(4, 4) from the rigid frame of a prim to the world."""
        prim = self.stage.GetPrimAtPath(path)
        found, _ = frame_and_scale(self._cache.GetLocalToWorldTransform(prim))
        return self.placed(found)

    def placed(self, stage_from_body: Array) -> Array:
        """A rigid frame in the stage's units and axes as one in the world's."""
        frame = np.eye(4)
        frame[:3, :3] = self.turn @ stage_from_body[:3, :3]
        frame[:3, 3] = self.metres * (self.turn @ stage_from_body[:3, 3])
        return frame

    def ordered(self, paths: Collection[Sdf.Path]) -> Iterator[Sdf.Path]:
        """Paths of prims in the order of the stage."""
        waiting = set(paths)
        for prim in Usd.PrimRange(self.stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
            if not waiting:
                return
            if prim.GetPath() in waiting:
                waiting.discard(prim.GetPath())
                yield prim.GetPath()
        yield from sorted(waiting)

    def gravity(self, scenes: Sequence[UsdPhysics.SceneDesc]) -> Array:
        """(3,) gravity of the first scene, m/s2; the earth's where none is authored."""
        down, pull = np.array([0.0, 0.0, -1.0]), STANDARD_GRAVITY
        for scene in scenes[:1]:
            given = np.array(scene.gravityDirection, dtype=np.float64)
            if np.linalg.norm(given) > 0.0:
                down = self.turn @ (given / np.linalg.norm(given))
            # Negative stands for that of the earth, and the number is a single-precision one.
            if 0.0 <= scene.gravityMagnitude < np.inf:
                pull = round(scene.gravityMagnitude * self.metres, 6)
        return np.asarray(down * pull)


Loss = tuple[str, Literal["approximated", "skipped"], str]
Pieces = tuple[TriangleMesh, ...]

# Of a shape without a material, where engines differ: the mean of all substances.
UNKNOWN: Final = Contact(0.53, 0.39, 0.0, "unknown")
# A plane has no end; this half side and this depth stand in for it, metres.
_PLANE, _DEPTH = 50.0, 1.0
_UNSAFE: Final = re.compile(r"[^A-Za-z0-9_]+")
# Places that differ by less are equal: repeats then share their points.
_PLACE_DIGITS: Final = 9
# Corners are stored in single precision: so far may they be off a face, as part of the size.
_FLAT_FACE_SHARE: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Collider:
    """What one prim collides with.

    Attributes:
        shapes: Convex ones.
        solids: Closed surfaces of what it weighs.
    """

    shapes: tuple[Shape, ...]
    solids: Pieces


@dataclass
class ShapeReader:
    """Reads colliders and visuals; what repeats is read once.

    Attributes:
        frames: Of the stage.
        losses: Receives what was approximated or skipped.
    """

    frames: Frames
    losses: dict[tuple[str, str], Loss] = field(default_factory=dict)
    _pieces: dict[tuple[str, str, bytes], tuple[Pieces, Pieces]] = field(default_factory=dict)
    _contacts: dict[str, Contact] = field(default_factory=dict)
    _baked: dict[tuple[int, bytes], TriangleMesh] = field(default_factory=dict)
    _worn: dict[str, list[tuple[TriangleMesh, str]]] = field(default_factory=dict)

    def collider(self, path: Sdf.Path, desc: Any, link_from_world: Array) -> Collider:
        """A collider in the frame of its link; the names of its shapes repeat."""
        prim = self.frames.stage.GetPrimAtPath(path)
        place = np.round(link_from_world @ self.frames.world(prim), _PLACE_DIGITS)
        key = (_shared(prim), str(getattr(desc, "approximation", "")), place.tobytes())
        if key not in self._pieces:
            self._pieces[key] = self._read(prim, desc, key[1], place)
        pieces, solids = self._pieces[key]
        name, contact = safe(prim.GetName()), self._contact(desc.materials)
        return Collider(tuple(Shape(name, mesh, contact) for mesh in pieces), solids)

    def _read(
        self, prim: Usd.Prim, desc: Any, approximation: str, place: Array
    ) -> tuple[Pieces, Pieces]:
        """The convex pieces of a collider, and the solids that its mass is of."""
        if isinstance(desc, UsdPhysics.PlaneShapeDesc):
            self.lose(prim.GetPath(), "approximated", "an endless plane is a large box")
            return (_baked(_slab(str(desc.axis)), place),), ()
        surface = read_surface(prim)
        if surface.mesh is None:
            reason = surface.losses[0][1] if surface.losses else "it has no surface"
            self.lose(prim.GetPath(), "skipped", reason)
            return (), ()
        points = surface.mesh.points @ place[:3, :3].T + place[:3, 3]
        placed = TriangleMesh(points, _wound(surface.mesh, place), surface.mesh.faces)
        if approximation in _CONCAVE:
            self.lose(prim.GetPath(), "approximated", "a mesh that may be concave: convex pieces")
        try:
            pieces = tuple(_APPROXIMATIONS.get(approximation, _decomposed)(placed))
        except InputError as error:
            self.lose(prim.GetPath(), "skipped", error.message)
            return (), ()
        # Round shapes weigh what they are, whatever few corners they collide with.
        return pieces, pieces if approximation else (placed,)

    def _contact(self, materials: list[Sdf.Path]) -> Contact:
        path = str(materials[0]) if len(materials) else ""
        prim = self.frames.stage.GetPrimAtPath(path) if path else None
        if not prim:
            return UNKNOWN
        key = _shared(prim)
        if key not in self._contacts:
            made = physics.read(prim)
            self._contacts[key] = (
                UNKNOWN
                if made is None
                else Contact(
                    made.static_friction,
                    min(made.dynamic_friction, made.static_friction),
                    min(made.restitution, 1.0),
                    prim.GetName(),
                )
            )
        return self._contacts[key]

    def visuals(self, placed: PlacedMesh, link_from_world: Array) -> Iterator[Visual]:
        """What is seen of a surface in the frame of a link, material by material."""
        name = safe(placed.path.rpartition("/")[2])
        M = np.round(link_from_world @ placed.world_from_local, _PLACE_DIGITS)
        for mesh, material in self._worn_by(placed):
            key = (id(mesh), M.tobytes())
            if key not in self._baked:
                self._baked[key] = _baked(mesh, M)
            yield Visual(name, self._baked[key], material)

    def _worn_by(self, placed: PlacedMesh) -> list[tuple[TriangleMesh, str]]:
        key = _shared(placed.prim)
        if key not in self._worn:
            self._worn[key] = list(_by_material(placed.prim, placed.mesh))
        return self._worn[key]

    def lose(self, path: object, outcome: Literal["approximated", "skipped"], reason: str) -> None:
        """Note what is not as the stage has it."""
        self.losses.setdefault((str(path), reason), (str(path), outcome, reason))


def safe(name: str) -> str:
    """A name of letters, digits and underscores."""
    return _UNSAFE.sub("_", name).strip("_") or "part"


def _shared(prim: Usd.Prim) -> str:
    """The same for all that show one prim of a prototype."""
    return str((prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim).GetPath())


def _wound(mesh: TriangleMesh, place: Array) -> NDArray[np.int32]:
    return mesh.triangles[:, ::-1] if np.linalg.det(place[:3, :3]) < 0.0 else mesh.triangles


def _slab(axis: str) -> TriangleMesh:
    """The box below a plane."""
    ends = np.array([[-_PLANE, -_PLANE, -_DEPTH], [_PLANE, _PLANE, 0.0]])
    ends = np.roll(ends, {"X": 1, "Y": 2}.get(axis[-1], 0), axis=1)
    none = np.zeros(0, dtype=np.int32)
    return bounding_box(TriangleMesh(ends, none.reshape(0, 3), none))


def _hull(mesh: TriangleMesh) -> list[TriangleMesh]:
    return [mesh if _is_convex(mesh) else convex_hull(mesh.points)]


def _is_convex(mesh: TriangleMesh) -> bool:
    """Whether a mesh of few corners is its own hull: it then stays as it is, to the last bit."""
    if len(mesh.points) > MOST_VERTICES:
        return False
    faces = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, uses = np.unique(faces, axis=0, return_counts=True)
    planes = half_spaces(mesh)
    outside = mesh.points @ planes[:, :3].T + planes[:, 3]
    size = float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    return bool((uses == 2).all() and outside.max() <= _FLAT_FACE_SHARE * size)


def _bounding_box(mesh: TriangleMesh) -> list[TriangleMesh]:
    return [bounding_box(mesh)]


def _bounding_sphere(mesh: TriangleMesh) -> list[TriangleMesh]:
    middle = 0.5 * (mesh.points.min(axis=0) + mesh.points.max(axis=0))
    radius = float(np.linalg.norm(mesh.points - middle, axis=1).max())
    return [convex_hull(sphere(radius, center=middle).points)]


def _decomposed(mesh: TriangleMesh) -> list[TriangleMesh]:
    found = collision_shapes([Part("mesh", mesh.points, mesh.triangles)])
    return [shape.mesh for shape in found.shapes]


_CONCAVE: Final = ("none", "meshSimplification")
_APPROXIMATIONS: Final[dict[str, Callable[[TriangleMesh], list[TriangleMesh]]]] = {
    "": _hull,
    "convexHull": _hull,
    "boundingCube": _bounding_box,
    "boundingSphere": _bounding_sphere,
}


def _by_material(prim: Usd.Prim, mesh: TriangleMesh) -> Iterator[tuple[TriangleMesh, str]]:
    """The triangles of each material."""
    rest = np.ones(len(mesh.triangles), dtype=np.bool_)
    for faces, material in bound_subsets(prim):
        own = np.isin(mesh.faces, faces)
        rest &= ~own
        if own.any():
            yield _some(mesh, own), str(material.GetPath())
    if rest.any():
        whole = bound_material(prim)
        path = str(whole.GetPath()) if whole is not None else ""
        yield mesh if rest.all() else _some(mesh, rest), path


def _some(mesh: TriangleMesh, kept: Mask) -> TriangleMesh:
    return TriangleMesh(
        mesh.points,
        mesh.triangles[kept],
        mesh.faces[kept],
        None if mesh.normals is None else mesh.normals[kept],
        {name: uv[kept] for name, uv in mesh.uvs.items()},
    )


def _baked(mesh: TriangleMesh, place: Array) -> TriangleMesh:
    """A mesh with a matrix applied to it; mirrors keep its outside."""
    mirrored = np.linalg.det(place[:3, :3]) < 0.0
    order = slice(None, None, -1) if mirrored else slice(None)
    normals = mesh.normals
    if normals is not None:
        turned = unit(normals.astype(np.float64) @ np.linalg.inv(place[:3, :3]))
        normals = turned.astype(np.float32)[:, order]
    return TriangleMesh(
        mesh.points @ place[:3, :3].T + place[:3, 3],
        np.ascontiguousarray(mesh.triangles[:, order]),
        mesh.faces,
        normals,
        {name: uv[:, order] for name, uv in mesh.uvs.items()},
    )
