"""The room around its furniture: floor, ceiling, and the walls that objects hang on.

Everything is read from the composed stage, in the frame of ``/World``: a room that was moved in the
edits layer carries and holds its furniture where it is now.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from pxr import Gf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.slopes import heights_over, sloping
from openrooms_usd.usd.places.frames import TIME, local_to_world, matrix
from openrooms_usd.usd.places.partitions import read_partitions
from openrooms_usd.usd.shapes.gprims import read_surface

# Largest distance of an opening's middle from the inner edge of its wall, metres.
_ON_THE_EDGE: Final = 0.02


class Hung(NamedTuple):
    """Where something hangs.

    Attributes:
        wall: The number of the wall in `RoomGeometry.faces`.
        along: Its middle along the wall, metres from the wall's start.
        x: Middle of its base, metres.
        y: Middle of its base, metres.
        yaw: Degrees: its front looks away from the wall.
    """

    wall: int
    along: float
    x: float
    y: float
    yaw: float


class Gap(NamedTuple):
    """An opening in a wall.

    Attributes:
        name: Its prim name.
        wall: The number of its wall.
        along: Its middle along the wall, metres from the wall's start.
        width: Metres.
        bottom: Its lower edge, metres.
        top: Its upper edge, metres.
    """

    name: str
    wall: int
    along: float
    width: float
    bottom: float
    top: float


@dataclass(frozen=True, eq=False)
class RoomGeometry:
    """The room without its furniture, in the frame of ``/World``.

    Attributes:
        floor: Height of the floor, metres.
        ceiling: Height of the ceiling, at its lowest, metres; None in a room without one.
        walls: (N, 2, 2) start and end of the walls' inner edges, metres, counter-clockwise; empty
            where the room has no polygon.
        gaps: The openings in the walls that things hang on.
        partitions: (P, 2, 2) start and end of both faces of each wall that stands free, metres,
            with the room on their left.
        slopes: (N, 3, 3) the lower faces of a ceiling that is not level, metres.
    """

    floor: float = 0.0
    ceiling: float | None = None
    walls: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))
    gaps: tuple[Gap, ...] = ()
    partitions: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))
    slopes: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))

    def ceiling_over(self, x: float, y: float) -> float | None:
        """Height of the ceiling over a place, metres; None in a room without one."""
        if self.ceiling is None or not len(self.slopes):
            return self.ceiling
        return float(heights_over(self.slopes, np.array([[x, y]]), self.ceiling)[0])

    @property
    def faces(self) -> Array:
        """(N + P, 2, 2) the walls that things hang on: those of the outline, then the others."""
        return np.concatenate([self.walls, self.partitions])

    def hang(self, x: float, y: float, width: float, depth: float) -> Hung:
        """Bring a box with its back flush to the wall that is nearest to a place.

        It stays within the wall's length where it fits, else it hangs in its middle.

        Args:
            x: The place, metres.
            y: The place, metres.
            width: Of the box along the wall, metres.
            depth: Of the box off the wall, metres.
        """
        starts, steps = self.faces[:, 0], self.faces[:, 1] - self.faces[:, 0]
        lengths = np.linalg.norm(steps, axis=1)
        offsets = np.array([x, y]) - starts
        along = np.clip((offsets * steps).sum(axis=1) / lengths, 0.0, lengths)
        feet = starts + steps * (along / lengths)[:, None]
        wall = int(np.argmin(np.linalg.norm(np.array([x, y]) - feet, axis=1)))
        ahead, length = steps[wall] / lengths[wall], float(lengths[wall])
        half = min(0.5 * width, 0.5 * length)
        place = float(np.clip(along[wall], half, length - half))
        # The room lies on the left of its walls, and the back of an object is its +Y side.
        inward = np.array([-ahead[1], ahead[0]])
        at = starts[wall] + place * ahead + 0.5 * depth * inward
        yaw = float(np.degrees(np.arctan2(-ahead[1], -ahead[0])))
        return Hung(wall, place, float(at[0]), float(at[1]), yaw)

    def length(self, wall: int) -> float:
        """Length of a wall, metres."""
        return float(np.linalg.norm(self.faces[wall, 1] - self.faces[wall, 0]))

    def covered(self, hung: Hung, width: float, bottom: float, top: float) -> list[str]:
        """The openings that something on a wall would cover, by name."""
        return [
            gap.name
            for gap in self.gaps
            if gap.wall == hung.wall
            and abs(gap.along - hung.along) < 0.5 * (gap.width + width)
            and gap.bottom < top
            and bottom < gap.top
        ]


def surroundings(stage: Usd.Stage) -> RoomGeometry:
    """Read the room of a composed stage; what it does not have is left out."""
    world = stage.GetPrimAtPath(names.WORLD)
    boxes = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])

    def extent(path: str) -> Gf.Range3d:
        prim = stage.GetPrimAtPath(path)
        bound = boxes.ComputeRelativeBound(prim, world) if prim else Gf.BBox3d()
        return bound.ComputeAlignedRange()

    below, above = extent(names.FLOOR), extent(names.CEILING)
    cache = UsdGeom.XformCache(TIME)
    walls, standing = _walls(stage, cache), _partitions(stage, cache)
    return RoomGeometry(
        0.0 if below.IsEmpty() else below.GetMax()[2],
        None if above.IsEmpty() else above.GetMin()[2],
        walls,
        tuple(_gaps(stage, np.concatenate([walls, standing]), len(walls), cache)),
        standing,
        _slopes(stage, cache),
    )


def _slopes(stage: Usd.Stage, cache: UsdGeom.XformCache) -> Array:
    prim = stage.GetPrimAtPath(names.CEILING)
    mesh = read_surface(prim, bare=True).mesh if prim and prim.IsA(UsdGeom.Gprim) else None
    if mesh is None:
        return np.zeros((0, 3, 3))
    frame = _in_world(prim, cache)
    return sloping((mesh.points @ frame[:3, :3].T + frame[:3, 3])[mesh.triangles])


def _in_world(prim: Usd.Prim, cache: UsdGeom.XformCache) -> Array:
    """(4, 4) from a prim's frame to that of ``/World``."""
    world = cache.GetLocalToWorldTransform(prim.GetStage().GetPrimAtPath(names.WORLD))
    return matrix(cache.GetLocalToWorldTransform(prim) * world.GetInverse())


def _walls(stage: Usd.Stage, cache: UsdGeom.XformCache) -> Array:
    room = stage.GetPrimAtPath(names.ROOM)
    attribute = room.GetAttribute(names.ROOM_FLOOR) if room else None
    corners = np.array(attribute.Get(TIME) if attribute and attribute.HasValue() else [])
    if corners.ndim != 2 or len(corners) < 3 or not np.isfinite(corners).all():
        return np.zeros((0, 2, 2))
    frame = _in_world(room, cache)
    placed = corners.astype(np.float64) @ frame[:2, :2].T + frame[:2, 3]
    edges = np.stack([placed, np.roll(placed, -1, axis=0)], axis=1)
    return np.asarray(edges[np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1) > 0.0])


def _partitions(stage: Usd.Stage, cache: UsdGeom.XformCache) -> Array:
    """(P, 2, 2) the faces of the walls that stand free."""
    found = [wall.faces for wall in read_partitions(stage)]
    if not found:
        return np.zeros((0, 2, 2))
    frame = np.linalg.inv(local_to_world(stage.GetPrimAtPath(names.WORLD), cache))
    return np.asarray(np.concatenate(found) @ frame[:2, :2].T + frame[:2, 3])


def _gaps(stage: Usd.Stage, walls: Array, outline: int, cache: UsdGeom.XformCache) -> Iterator[Gap]:
    """The openings in walls (N, 2, 2), of which the first ones are those of the outline."""
    openings = stage.GetPrimAtPath(names.OPENINGS)
    lengths = np.linalg.norm(walls[:, 1] - walls[:, 0], axis=1)
    ahead = (walls[:, 1] - walls[:, 0]) / lengths[:, None]
    # The faces of a wall that stands free come in pairs, as far apart as it is thick.
    deep = np.zeros(len(walls))
    pairs = walls[outline:].reshape(-1, 2, 2, 2)
    across = np.stack([-ahead[outline::2, 1], ahead[outline::2, 0]], axis=-1)
    depths = np.abs(((pairs[:, 1, 0] - pairs[:, 0, 0]) * across).sum(axis=1))
    deep[outline:] = np.repeat(depths, 2)
    for prim in openings.GetAllChildren() if openings and len(walls) else ():
        sizes = [prim.GetAttribute(key) for key in (names.OPENING_WIDTH, names.OPENING_HEIGHT)]
        if not UsdGeom.Xformable(prim) or not all(size and size.HasValue() for size in sizes):
            continue
        width, height = (float(size.Get(TIME)) for size in sizes)
        x, y, z = _in_world(prim, cache)[:3, 3].tolist()
        offsets = np.array([x, y]) - walls[:, 0]
        along = (offsets * ahead).sum(axis=1)
        off = np.abs(ahead[:, 0] * offsets[:, 1] - ahead[:, 1] * offsets[:, 0])
        on = np.flatnonzero((off < deep + _ON_THE_EDGE) & (along > 0.0) & (along < lengths))
        low, high = z - 0.5 * height, z + 0.5 * height
        # A hole in a wall that stands free is seen on both of its faces.
        for wall in on[: 1 if on.size and on[0] < outline else 2].tolist():
            yield Gap(prim.GetName(), wall, float(along[wall]), width, low, high)
