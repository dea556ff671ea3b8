"""A room's outline and its holes, from the layout's mesh or around what stands in it.

The released meshes have a floor, a ceiling and thin walls with true holes; our rooms have walls
with a thickness, so that no light leaks in and no second shell is needed. So the mesh is read as a
plan: the floor's outline, the ceiling's height, and rectangles that the walls leave open.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError

if TYPE_CHECKING:
    import shapely


# Every room of the release has this height.
RELEASE_HEIGHT_M: Final = 3.0
_FARTHEST_M: Final = 1e5
_MOST_TRIANGLES: Final = 100_000
# Rounding of the files, and how far faces of one floor or wall may lie apart.
_FLAT_M: Final = 0.02
_STRAIGHT_M: Final = 0.005
_LEVEL: Final = 0.99
_UPRIGHT: Final = 0.1
_LEAST_HOLE_M: Final = 0.2
# Walls without faces over more than this part of their length were never drawn.
_MOST_OPEN_SHARE: Final = 0.95
# Around objects where no layout is known.
_MARGIN_M: Final = 0.3


@dataclass(frozen=True, eq=False)
class Hole:
    """A rectangle that a wall leaves open.

    Attributes:
        center: (3,) metres.
        direction: (3,) unit vector along its width.
        width: Metres.
        height: Metres.
    """

    center: Array
    direction: Array
    width: float
    height: float


@dataclass(frozen=True, eq=False)
class Shell:
    """A room's plan: Z up, metres, the floor at 0.

    Attributes:
        floor: (N, 2) corners.
        level: The floor's height in the mesh's own frame.
        height: Floor to ceiling.
        holes: In its walls.
        repeats: Units of texture coordinates in a metre of the floor; None without them.
    """

    floor: Array
    level: float
    height: float
    holes: tuple[Hole, ...]
    repeats: float | None = None


def shell_of(triangles: Array, st: Array | None, place: str) -> Shell:
    """The plan of a layout's mesh.

    Args:
        triangles: (N, 3, 3) metres, Z up.
        st: (N, 3, 2) texture coordinates.
        place: The mesh, for messages.

    Raises:
        InputError: It has no level faces that bound one floor.
    """
    import shapely

    if len(triangles) > _MOST_TRIANGLES:
        raise _no_floor(place, f"it has {len(triangles):,} triangles, where layouts have hundreds")
    if not np.isfinite(triangles).all() or (np.abs(triangles) > _FARTHEST_M).any():
        raise _no_floor(place, "it has coordinates that are not finite")
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    triangles, normals = triangles[areas > 0.0], normals[areas > 0.0]
    up = np.abs(normals[:, 2]) / areas[areas > 0.0]
    level = triangles[up > _LEVEL]
    if not len(level):
        raise _no_floor(place, "it has no level face")
    low, high = level[..., 2].min(), level[..., 2].max()
    flat = level[np.abs(level[..., 2].mean(axis=1) - low) < _FLAT_M]
    union = shapely.union_all([shapely.Polygon(one[:, :2]) for one in flat], grid_size=1e-4)
    parts = shapely.get_parts(union.simplify(_STRAIGHT_M))
    outline = max(parts, key=lambda part: part.area, default=None)
    floor = _corners(outline) if isinstance(outline, shapely.Polygon) else np.empty((0, 2))
    if len(floor) < 3:
        raise _no_floor(place, "its lowest faces bound no floor")
    has_ceiling = high - low > 2.0 * _FLAT_M
    height = float(high - low if has_ceiling else triangles[..., 2].max() - low)
    if height <= 0.0:
        raise _no_floor(place, "it has no height")
    walls = triangles[up < _UPRIGHT]
    holes = [hole for one in _edges(floor) for hole in _holes(one, walls, float(low), height)]
    on_floor = np.flatnonzero(areas > 0.0)[up > _LEVEL]
    repeats = None if st is None else _repeats(level, st[on_floor])
    return Shell(floor, float(low), height, tuple(holes), repeats)


def shell_around(points: Array, directions: Sequence[Array], holes: Sequence[Hole]) -> Shell:
    """A rectangle around everything, where there is no layout's mesh.

    Args:
        points: (N, 3) corners of boxes, metres, Z up; the floor is at 0.
        directions: (3,) along walls, such as those of doors; its sides follow the first.
        holes: Openings, which lie in its sides where they can.
    """
    along = directions[0][:2] if directions else np.array([1.0, 0.0])
    along = along / np.linalg.norm(along)
    axes = np.stack([along, [-along[1], along[0]]])
    inside = points[:, :2] @ axes.T
    doors = np.array([hole.center[:2] for hole in holes]).reshape(-1, 2) @ axes.T
    low, high = inside.min(axis=0) - _MARGIN_M, inside.max(axis=0) + _MARGIN_M
    for axis in range(2):
        across = [
            door[axis]
            for door, hole in zip(doors, holes, strict=True)
            if abs(hole.direction[:2] @ axes[axis]) < 0.5
        ]
        middle = float(inside[:, axis].mean())
        # Doors and windows say where their walls are better than furniture does.
        low[axis] = min((d for d in across if d < middle), default=low[axis])
        high[axis] = max((d for d in across if d >= middle), default=high[axis])
    corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
    return Shell(np.array(corners) @ axes, 0.0, RELEASE_HEIGHT_M, tuple(holes))


def _corners(outline: "shapely.Polygon") -> Array:
    """The corners of a polygon, counter-clockwise, without those on straight sides."""
    ring = np.array(outline.exterior.coords)[:-1]
    if outline.exterior.is_ccw is False:
        ring = ring[::-1]
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turn = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    lengths = np.linalg.norm(before, axis=1) + np.linalg.norm(after, axis=1)
    return np.asarray(ring[turn > _STRAIGHT_M * lengths * 0.5])


def _edges(floor: Array) -> Iterator[tuple[Array, Array]]:
    yield from zip(floor, np.roll(floor, -1, axis=0), strict=True)


def _holes(edge: tuple[Array, Array], walls: Array, low: float, height: float) -> Iterator[Hole]:
    """What the faces in an edge's plane leave open."""
    import shapely

    start, end = edge
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    across = np.array([-along[1], along[0]])
    away = np.abs((walls[..., :2] - start) @ across).max(axis=1)
    own = walls[away < _FLAT_M]
    drawn = np.stack([(own[..., :2] - start) @ along, own[..., 2] - low], axis=-1)
    wall = shapely.box(0.0, 0.0, length, height)
    faces = shapely.union_all([shapely.Polygon(one) for one in drawn if len(one)])
    if wall.area - wall.intersection(faces).area > _MOST_OPEN_SHARE * wall.area:
        return
    left = wall.difference(faces.buffer(_STRAIGHT_M))
    for part in getattr(left, "geoms", [left]):
        x0, z0, x1, z1 = part.buffer(_STRAIGHT_M, join_style="mitre").bounds
        # Bounds of an empty mesh are not finite.
        if not min(x1 - x0, z1 - z0) >= _LEAST_HOLE_M:
            continue
        x0, x1 = max(x0, 0.0), min(x1, length)
        z0, z1 = max(z0, 0.0), min(z1, height)
        middle = start + along * 0.5 * (x0 + x1)
        center = np.array([*middle, 0.5 * (z0 + z1)])
        yield Hole(center, np.array([*along, 0.0]), x1 - x0, z1 - z0)


def _repeats(triangles: Array, st: Array) -> float | None:
    """The root of the ratio of areas in texture coordinates and in metres."""

    def areas(corners: Array) -> float:
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        return float(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())

    ratio = areas(st) / max(areas(triangles[..., :2]), 1e-12)
    return float(np.sqrt(ratio)) if np.isfinite(ratio) and ratio > 0.0 else None


def _no_floor(place: str, why: str) -> InputError:
    return InputError(
        f"no room can be read from this layout: {why}",
        place=place,
        remedy="omit the layout to use a rectangle around the objects",
    )
