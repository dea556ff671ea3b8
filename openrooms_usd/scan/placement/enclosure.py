"""Walls, floor and ceiling around objects, and the penetration of objects into them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.polygons import turns
from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.scan.placement.bodies import Body

# Range within which walls are tested against an object, metres.
_NEAR_WALL_M: Final = 0.3
# Spacing of points along a body's edges, so that reflex corners of the room are not missed, metres.
_EDGE_SAMPLE_M: Final = 0.004
_INSIDE_M: Final = 2e-4
# What reaches farther beyond a wall than this stands elsewhere, metres.
LOST_M: Final = 0.4
# Objects that no motion brings nearer than this to the inside stay, metres.
_HOPELESS_M: Final = 0.1


@dataclass(frozen=True)
class Facing:
    """The wall that a body faces.

    Attributes:
        wall: Its number.
        gap: Between them, metres; negative for a penetration.
        angle: The yaw that makes the body parallel to it, radians.
    """

    wall: int
    gap: float
    angle: float


@dataclass(frozen=True, eq=False)
class Enclosure:
    """A room without its openings.

    Attributes:
        corners: (N, 2) counter-clockwise, metres.
        floor: Its height, metres.
        ceiling: Its height; None where it is not known.
    """

    corners: Array
    floor: float
    ceiling: float | None

    @cached_property
    def inward(self) -> Array:
        """(N, 2) unit normals of the walls, into the room."""
        along = unit(np.roll(self.corners, -1, axis=0) - self.corners)
        return np.stack([-along[:, 1], along[:, 0]], axis=1)

    @cached_property
    def _lengths(self) -> Array:
        return np.asarray(np.linalg.norm(np.roll(self.corners, -1, axis=0) - self.corners, axis=1))

    @cached_property
    def _polygon(self) -> Any:
        import shapely

        polygon = shapely.Polygon(self.corners)
        shapely.prepare(polygon)
        return polygon

    def distance(self, point: Array) -> float:
        """Distance of a point (2,) to the room, metres; 0 inside."""
        return float(self.beyond(point[None])[0])

    def beyond(self, points: Array) -> Array:
        """(P,) distances of points (P, 2) to the room, metres; 0 inside."""
        import shapely

        return np.asarray(shapely.distance(self._polygon, shapely.points(points)))

    def outward(self, points: Array) -> Array:
        """(P, 2) the ways from the room to points (P, 2), metres; 0 inside."""
        import shapely

        lines = shapely.shortest_line(self._polygon, shapely.points(points))
        ends = shapely.get_coordinates(lines).reshape(-1, 2, 2)
        return np.asarray(ends[:, 1] - ends[:, 0])

    def footprint(self, body: Body) -> Array:
        """(P, 2) points of a body's plan that suffice to measure its penetration of walls.

        The corners of its convex hull, unless a reflex corner of the room may penetrate it.
        """
        reflex = self.corners[turns(self.corners) < 0.0]
        low, high = body.low[:2] - _NEAR_WALL_M, body.high[:2] + _NEAR_WALL_M
        reflex = reflex[((reflex > low) & (reflex < high)).all(axis=1)]
        return _dense(body.triangles[..., :2], reflex) if len(reflex) else body.outline

    def leave(self, points: Array) -> dict[int, float]:
        """The walls that points (P, 2) must leave, and how far, by the least motion.

        At a reflex corner leaving one of its two walls is enough; at other corners both count.
        Points more than 0.4 m beyond walls are not brought back, nor bodies that do not fit.
        """
        out = points[self.beyond(points) > _INSIDE_M]
        if not len(out):
            return {}
        depth = np.einsum("ij,ij->i", self.inward, self.corners)[:, None] - self.inward @ out.T
        along = self._along(out)
        close = (
            (depth > 0) & (along > -_NEAR_WALL_M) & (along < self._lengths[:, None] + _NEAR_WALL_M)
        )
        walls = np.flatnonzero(close.any(axis=1)).tolist()
        choices = [*combinations(walls, 1), *combinations(walls, 2)]
        ways = [self._way(choice, depth, points) for choice in choices]
        ways = [w for w in ways if max(w[0].values()) < LOST_M and w[1] < _HOPELESS_M]
        # The remaining penetration counts more than the length of the motion.
        return min(ways, key=lambda way: (round(way[1], 3), way[2]), default=({}, 0.0, 0.0))[0]

    def _way(
        self, walls: Sequence[int], depth: Array, points: Array
    ) -> tuple[dict[int, float], float, float]:
        """Motion out of each wall, the penetration after it, and its total length."""
        needed = np.maximum(depth[list(walls)].max(axis=1), 0.0)
        motion = np.linalg.lstsq(self.inward[list(walls)], needed, rcond=None)[0]
        left = float(self.beyond(points + (1.0 + 1e-9) * motion).max())
        found = dict(zip(walls, needed.tolist(), strict=True))
        return found, max(0.0, left - _INSIDE_M), float(np.linalg.norm(motion))

    def gaps(self, points: Array) -> dict[int, float]:
        """Gaps between points (P, 2) and the near walls that they face, metres."""
        height = self.inward @ points.T
        height -= np.einsum("ij,ij->i", self.inward, self.corners)[:, None]
        along = self._along(points)
        before = (along > 0.0) & (along < self._lengths[:, None])
        gap = np.where(before, height, np.inf).min(axis=1)
        return {
            i: float(gap[i]) for i in np.flatnonzero((gap < _NEAR_WALL_M) & (gap > -1e-3)).tolist()
        }

    def _along(self, points: Array) -> Array:
        """(N, P) the projection of each point on each wall, metres along it."""
        way = np.roll(self.corners, -1, axis=0) - self.corners
        way /= self._lengths[:, None]
        return np.asarray(way @ points.T - np.einsum("ij,ij->i", way, self.corners)[:, None])

    def gap(self, body: Body, wall: int) -> float:
        """The gap between a body as it stands and a wall, metres; negative for a penetration."""
        return float(((body.outline - self.corners[wall]) @ self.inward[wall]).min())

    def facing(self, body: Body, reach: float = _NEAR_WALL_M) -> Facing | None:
        """The nearest wall that a body faces; None where none is within reach."""
        middle = 0.5 * (body.low + body.high)[None, :2]
        along, best = self._along(middle)[:, 0], None
        for wall in np.flatnonzero((along > 0.0) & (along < self._lengths)).tolist():
            angle = _parallel(body.axes, self.inward[wall])
            points = (body.outline - middle) @ about_z(angle)[:2, :2].T + middle
            gap = float(((points - self.corners[wall]) @ self.inward[wall]).min())
            if abs(gap) < reach and (best is None or abs(gap) < abs(best.gap)):
                best = Facing(wall, gap, angle)
        return best


def _parallel(axes: Array, normal: Array) -> float:
    """The least rotation that makes one of some axes parallel to a normal, radians."""
    angle = np.arctan2(normal[1], normal[0]) - np.arctan2(axes[0, 1], axes[0, 0])
    quarter = 0.5 * np.pi
    return float(angle - quarter * np.round(angle / quarter))


def _dense(plan: Array, reflex: Array) -> Array:
    """(P, 2) corners of triangles, and points on their edges near reflex corners of the room."""
    start, end = plan.reshape(-1, 2), np.roll(plan, -1, axis=1).reshape(-1, 2)
    low, high = np.minimum(start, end)[:, None], np.maximum(start, end)[:, None]
    around = (low < reflex + _NEAR_WALL_M) & (high > reflex - _NEAR_WALL_M)
    close = np.any(np.all(around, axis=2), axis=1)
    start, way = start[close], (end - start)[close]
    counts = np.ceil(np.linalg.norm(way, axis=1) / _EDGE_SAMPLE_M).astype(np.int64)
    row = np.repeat(np.arange(len(start)), counts)
    number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    points = start[row] + (number / np.maximum(counts[row], 1))[:, None] * way[row]
    points = np.concatenate([plan.reshape(-1, 2), points])
    _, kept = np.unique(
        np.round(points / (0.5 * _EDGE_SAMPLE_M)).astype(np.int64) @ [1 << 32, 1], return_index=True
    )
    return np.asarray(points[np.sort(kept)])
