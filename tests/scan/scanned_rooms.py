"""Clouds of simple rooms whose truth is known exactly: walls, floor, ceiling, boxes, holes."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely

from openrooms_usd.arrays import Array
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.rooms.layout import find_layout
from openrooms_usd.scan.rooms.levelling import level

WALL, FLOOR, CABINET, DOOR, CEILING = 1, 2, 3, 8, 22
SQUARE = ((0.0, 0.0), (4.2, 0.0), (4.2, 3.1), (0.0, 3.1))


@dataclass(frozen=True)
class RoomScan:
    """How a room is sampled: a jittered grid on every surface.

    Attributes:
        corners: Counter-clockwise, metres.
        height: Of the ceiling.
        spacing: Of the grid.
        noise: Standard deviation across surfaces.
        holes: (wall, from, to, bottom, top): no points there.
        boxes: (x, y, width, depth, bottom, top): furniture along the axes.
        missing: Numbers of walls without points.
        floor: Whether the floor has points.
        ceiling: Whether the ceiling has points.
    """

    corners: Sequence[tuple[float, float]]
    height: float = 2.5
    spacing: float = 0.035
    noise: float = 0.004
    holes: Sequence[tuple[int, float, float, float, float]] = ()
    boxes: Sequence[tuple[float, float, float, float, float, float]] = ()
    missing: Sequence[int] = field(default=())
    floor: bool = True
    ceiling: bool = True

    def cloud(self, seed: int = 0) -> Cloud:
        """The labelled points."""
        rng = np.random.default_rng(seed)
        parts = [*self._walls(rng), *self._levels(rng), *self._furniture(rng)]
        points = np.concatenate([p for p, _ in parts])
        label = np.concatenate([np.full(len(p), name, np.int32) for p, name in parts])
        return Cloud(points + self.noise * rng.normal(size=points.shape), label=label)

    def _walls(self, rng: np.random.Generator) -> list[tuple[Array, int]]:
        found = []
        count = len(self.corners)
        for i in set(range(count)) - set(self.missing):
            a, b = np.array(self.corners[i]), np.array(self.corners[(i + 1) % count])
            length = float(np.linalg.norm(b - a))
            u, z = self._grid(rng, length, self.height)
            kept = np.ones(len(u), bool)
            for wall, start, end, low, high in self.holes:
                if wall == i:
                    kept &= ~((u > start) & (u < end) & (z > low) & (z < high))
            plan = a + (u / length)[:, None] * (b - a)
            found.append((np.column_stack([plan, z])[kept], WALL))
        return found

    def _levels(self, rng: np.random.Generator) -> list[tuple[Array, int]]:
        shape = shapely.Polygon(self.corners)
        x0, y0, x1, y1 = shape.bounds
        found = []
        for z, name, wanted in ((0.0, FLOOR, self.floor), (self.height, CEILING, self.ceiling)):
            x, y = self._grid(rng, x1 - x0, y1 - y0)
            inside = shapely.contains_xy(shape, x + x0, y + y0)
            plane = np.column_stack([x + x0, y + y0, np.full(len(x), z)])[inside]
            found += [(plane, name)] if wanted else []
        return found

    def _furniture(self, rng: np.random.Generator) -> list[tuple[Array, int]]:
        found = []
        for x, y, w, d, low, high in self.boxes:
            for far in (0.0, 1.0):
                s, z = self._grid(rng, w, high - low)
                front = np.column_stack([x + s, np.full(len(s), y + far * d), low + z])
                s, z = self._grid(rng, d, high - low)
                side = np.column_stack([np.full(len(s), x + far * w), y + s, low + z])
                found += [(front, CABINET), (side, CABINET)]
            s, t = self._grid(rng, w, d)
            found.append((np.column_stack([x + s, y + t, np.full(len(s), high)]), CABINET))
        return found

    def _grid(self, rng: np.random.Generator, width: float, height: float) -> tuple[Array, Array]:
        u, v = (np.arange(0.0, size, self.spacing) for size in (width, height))
        grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
        grid = grid + self.spacing * rng.uniform(0.0, 1.0, grid.shape)
        return np.minimum(grid[:, 0], width), np.minimum(grid[:, 1], height)


def motion(tilt: float, yaw: float, offset: Sequence[float]) -> Array:
    """(4, 4) rigid: a turn about Z, then a tilt about a slanted axis, degrees, then a shift."""
    from scipy.spatial.transform import Rotation

    matrix = np.eye(4)
    axis = np.array([0.6, -0.8, 0.0]) * np.deg2rad(tilt)
    matrix[:3, :3] = (Rotation.from_rotvec(axis) * Rotation.from_euler("z", yaw, True)).as_matrix()
    matrix[:3, 3] = offset
    return matrix


def rings_found(cloud: Cloud) -> list[Array]:
    """The corners in plan of all rooms that the layout finds."""
    stand = level(cloud)
    rooms = find_layout(cloud.moved(stand.level_from_scan), stand)
    return [room.found(stand).corners[:, :2] for room in rooms]


def corner_error(found: Array, truth: Array) -> float:
    """The largest distance from a true corner to the nearest one found, and the other way."""
    apart = np.linalg.norm(found[:, None] - truth[None], axis=2)
    return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()))
