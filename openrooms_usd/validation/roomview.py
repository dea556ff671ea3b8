"""A composed room as people see it: its things, walls, cameras and light, in the world, metres."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from pxr import Gf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.slopes import heights_over, sloping
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.scan.placement.bodies import Body, solid
from openrooms_usd.usd.light.emitters import DistantLight, DomeLight
from openrooms_usd.usd.light.lights import read_portals
from openrooms_usd.usd.light.lightsearch import read_lights
from openrooms_usd.usd.places.frames import TIME, local_to_world, world_from_stage
from openrooms_usd.usd.places.partitions import StandingWall, read_partitions
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shapes.meshes import PlacedMesh, read_meshes

# How deep things may stand in the hole of a window, metres.
_MAX_REVEAL_M: Final = 0.6
_CORNERS: Final = np.indices((2, 2, 2)).reshape(3, -1).T


@dataclass(frozen=True, eq=False)
class RoomObject:
    """A piece of furniture.

    Attributes:
        path: Its prim.
        category: What it is; empty where nothing says it.
        frame: (3, 3) columns: its own axes in the world, unit.
        meshes: Its surfaces.
        low: (3,) least coordinates of a box around it.
        high: (3,) greatest.
        is_captured: Whether its place was measured in a capture.
    """

    path: str
    category: str
    frame: Array
    meshes: tuple[PlacedMesh, ...]
    low: Array
    high: Array
    is_captured: bool

    @property
    def name(self) -> str:
        """The last part of its path."""
        return self.path.rpartition("/")[2]

    @cached_property
    def points(self) -> Array:
        """(N, 3) of all its surfaces."""
        return np.concatenate([mesh.world_points() for mesh in self.meshes])

    @cached_property
    def triangles(self) -> Array:
        """(N, 3, 3) of all its surfaces, counter-clockwise from outside."""
        return _triangles(self.meshes)

    @cached_property
    def size(self) -> Array:
        """(3,) width, depth and height along its own axes."""
        return np.asarray(np.ptp(self.points @ self.frame, axis=0))

    @cached_property
    def body(self) -> Body:
        """The solid that it is."""
        counts = np.cumsum([0, *(len(mesh.mesh.points) for mesh in self.meshes)])
        faces = [
            (mesh.mesh.triangles[:, ::-1] if mesh.mirrored else mesh.mesh.triangles) + start
            for mesh, start in zip(self.meshes, counts, strict=False)
        ]
        return Body(solid(self.points, np.concatenate(faces)), unit(_level(self.frame)))


def _triangles(meshes: Iterable[PlacedMesh]) -> Array:
    found = [
        mesh.world_points()[mesh.mesh.triangles[:, ::-1] if mesh.mirrored else mesh.mesh.triangles]
        for mesh in meshes
    ]
    return np.concatenate(found) if found else np.zeros((0, 3, 3))


def _level(frame: Array) -> Array:
    """(2, 2) rows: the two axes of a frame nearest to the horizontal, in the plan."""
    return np.delete(frame.T, int(np.argmax(np.abs(frame[2]))), axis=0)[:, :2]


@dataclass(frozen=True, eq=False)
class Reveal:
    """The hole of a window in its wall, in which things may stand on the sill.

    Attributes:
        local_from_world: (4, 4) its middle in the wall's inner face, y to the outside.
        width: Metres.
        height: Metres.
    """

    local_from_world: Array
    width: float
    height: float

    def holds(self, points: Array) -> Mask:
        """(N,) which of (N, 3) places are in it."""
        x, y, z = (points @ self.local_from_world[:3, :3].T + self.local_from_world[:3, 3]).T
        across = (2.0 * np.abs(x) <= self.width) & (2.0 * np.abs(z) <= self.height)
        return np.asarray(across & (y >= 0.0) & (y <= _MAX_REVEAL_M))


@dataclass(frozen=True, eq=False)
class RoomView:
    """A room with what is in it.

    Attributes:
        stage: The composed stage.
    """

    stage: Usd.Stage

    @cached_property
    def _meshes(self) -> tuple[PlacedMesh, ...]:
        return tuple(read_meshes(self.stage, outside=False, bare=True))

    @cached_property
    def fixed(self) -> Array:
        """(N, 3, 3) triangles of the room's own surfaces."""
        return _triangles(m for m in self._meshes if m.path.startswith(f"{names.ROOM}/"))

    @cached_property
    def things(self) -> tuple[RoomObject, ...]:
        """What stands below the furniture's prim and can be seen."""
        found: dict[str, list[PlacedMesh]] = {}
        for mesh in self._meshes:
            if mesh.path.startswith(f"{names.FURNITURE}/"):
                name = mesh.path[len(names.FURNITURE) + 1 :].partition("/")[0]
                found.setdefault(f"{names.FURNITURE}/{name.partition('[')[0]}", []).append(mesh)
        return tuple(self._thing(path, meshes) for path, meshes in found.items())

    def _thing(self, path: str, meshes: list[PlacedMesh]) -> RoomObject:
        prim = self.stage.GetPrimAtPath(path)
        axes = local_to_world(prim, UsdGeom.XformCache(TIME))[:3, :3]
        corners = np.concatenate([self._corners(mesh) for mesh in meshes])
        label = read_label(prim, names.CATEGORY)
        return RoomObject(
            path,
            label or "",
            axes / np.maximum(np.linalg.norm(axes, axis=0), 1e-12),
            tuple(meshes),
            corners.min(axis=0),
            corners.max(axis=0),
            prim.HasAttribute(names.SOURCE_ID),
        )

    @cached_property
    def _boxes(self) -> dict[int, Array]:
        return {}

    def _corners(self, mesh: PlacedMesh) -> Array:
        """(8, 3) of the box around a mesh; equal meshes are measured once."""
        box = self._boxes.get(id(mesh.mesh))
        if box is None:
            ends = np.stack([mesh.mesh.points.min(axis=0), mesh.mesh.points.max(axis=0)])
            box = self._boxes[id(mesh.mesh)] = ends[_CORNERS, np.arange(3)]
        return np.asarray(box @ mesh.world_from_local[:3, :3].T + mesh.world_from_local[:3, 3])

    @cached_property
    def outline(self) -> Any:
        """The floor between the walls, a polygon of shapely; None where the room has none."""
        import shapely

        room = self.stage.GetPrimAtPath(names.ROOM)
        attribute = room.GetAttribute(names.ROOM_FLOOR) if room else None
        corners = np.array(attribute.Get(TIME) if attribute and attribute.HasValue() else [])
        if corners.ndim != 2 or len(corners) < 3 or not np.isfinite(corners).all():
            return None
        frame = local_to_world(room, UsdGeom.XformCache(TIME))
        frame = world_from_stage(self.stage) @ frame
        polygon = shapely.Polygon(corners @ frame[:2, :2].T + frame[:2, 3])
        shapely.prepare(polygon)
        return polygon if polygon.is_valid else None

    @cached_property
    def floor(self) -> float | None:
        """Height of the floor; None without one."""
        box = self._box(names.FLOOR)
        return None if box.IsEmpty() else float(box.GetMax()[2])

    @cached_property
    def ceiling(self) -> float | None:
        """Height of the ceiling, at its highest; None without one."""
        box = self._box(names.CEILING)
        highest = self._slopes[:, :, 2].max(initial=-np.inf)
        return None if box.IsEmpty() else float(max(highest, box.GetMin()[2]))

    def above_ceiling(self, points: Array) -> float:
        """How far the farthest of (N, 3) points is above the ceiling there; less than 0: below."""
        if self.ceiling is None:
            return -np.inf
        slopes = self._slopes
        if not len(slopes):
            return float(points[:, 2].max()) - self.ceiling
        return float((points[:, 2] - heights_over(slopes, points[:, :2], self.ceiling)).max())

    @cached_property
    def _slopes(self) -> Array:
        """(N, 3, 3) the lower faces of a ceiling that is not level."""
        return sloping(_triangles(m for m in self._meshes if m.path == names.CEILING))

    def _box(self, path: str) -> Gf.Range3d:
        prim = self.stage.GetPrimAtPath(path)
        boxes = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
        return boxes.ComputeWorldBound(prim).ComputeAlignedRange() if prim else Gf.Range3d()

    @cached_property
    def openings(self) -> tuple[tuple[str, str, float, float], ...]:
        """The path, the kind, the width and the height of each window, door and passage."""
        scope = self.stage.GetPrimAtPath(names.OPENINGS)
        found = []
        for prim in scope.GetChildren() if scope else ():
            width, height = (
                attribute.Get(TIME) if (attribute := prim.GetAttribute(name)) else None
                for name in (names.OPENING_WIDTH, names.OPENING_HEIGHT)
            )
            if width and height:
                kind = read_label(prim, names.CATEGORY) or "opening"
                found.append((str(prim.GetPath()), kind, float(width), float(height)))
        return tuple(found)

    @cached_property
    def reveals(self) -> tuple[Reveal, ...]:
        """The holes of all windows."""
        cache, to_world = UsdGeom.XformCache(TIME), world_from_stage(self.stage)
        found = []
        for path, kind, width, height in self.openings:
            prim = self.stage.GetPrimAtPath(path)
            if kind == "window":
                local = np.asarray(
                    np.linalg.inv(to_world @ local_to_world(prim, cache)), dtype=np.float64
                )
                found.append(Reveal(local, width, height))
        return tuple(found)

    @cached_property
    def partitions(self) -> tuple[StandingWall, ...]:
        """The walls that stand free."""
        return read_partitions(self.stage)

    @cached_property
    def cameras(self) -> tuple[tuple[str, Array], ...]:
        """The paths of all cameras and where they are, (3,)."""
        cache, to_world = UsdGeom.XformCache(TIME), world_from_stage(self.stage)
        return tuple(
            (str(prim.GetPath()), (to_world @ local_to_world(prim, cache))[:3, 3])
            for prim in self.stage.Traverse()
            if prim.IsA(UsdGeom.Camera)
        )

    @cached_property
    def is_lit(self) -> bool:
        """Whether any lamp shines, or the sky by an opening."""
        shining = [light for light in read_lights(self.stage) if light.radiance.max() > 0.0]
        if any(not isinstance(light, DomeLight | DistantLight) for light in shining):
            return True
        closed = self.ceiling is not None and self.outline is not None
        return bool(shining) and (not closed or bool(read_portals(self.stage)))

    def pairs(self, deeper: float) -> Iterator[tuple[RoomObject, RoomObject]]:
        """Things whose boxes overlap by more than so many metres along all axes."""
        order = sorted(self.things, key=lambda thing: float(thing.low[0]))
        open_: list[RoomObject] = []
        for thing in order:
            open_ = [other for other in open_ if other.high[0] > thing.low[0] + deeper]
            for other in open_:
                shared = np.minimum(other.high, thing.high) - np.maximum(other.low, thing.low)
                if (shared > deeper).all():
                    yield other, thing
            open_.append(thing)
