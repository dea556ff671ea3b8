"""Walls in the plan: their frames, their thickness and the outline that each of them covers.

A wall is seen from inside the room: x runs to the right along its inner edge, y outwards through
its thickness, z up. Its outline is the part of a strip along the edge that lies between the
bisectors of its two corners. So neighbours meet in mitres, whatever the angle, every outline is
convex, and no outline reaches into the room.
"""

from dataclasses import dataclass, replace

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.polygons import turns

# A mitre that would reach further out than this times the thickness is cut off.
MITRE_LIMIT = 2.0
# Where two walls stand back to back, each takes at most this much of the gap.
SHARE = 0.45
# Depth from which on a wall is tested against the rest of the room, metres.
NEAR = 5e-4


@dataclass(frozen=True, eq=False)
class Wall:
    """One wall of a room in the plan.

    Attributes:
        number: The number of its edge, as the polygon was given, or of the partition.
        left: (2,) the end of its inner edge on the left, seen from inside, metres.
        right: (2,) the other end.
        thickness: Metres.
        outline: (K, 2) convex, counter-clockwise in the wall's x and y; it begins with the inner
            edge (0, 0), (length, 0).
        start: How far the left end is along the room's walls, clockwise from corner 0, metres:
            patterns run on from wall to wall.
        partition: The name of a wall that stands free in the room; None for one of its outline.
        height: Of a wall that ends below the ceiling, metres.
        crown: (K, 2) its top under a ceiling that is not level: x along its inner edge, from end to
            end, and height, metres.
    """

    number: int
    left: Array
    right: Array
    thickness: float
    outline: Array
    start: float
    partition: str | None = None
    height: float | None = None
    crown: Array | None = None

    @property
    def name(self) -> str:
        """Its prim name."""
        return self.partition or f"wall_{self.number}"

    def top(self, ceiling: float, span: tuple[float, float] = (-np.inf, np.inf)) -> float:
        """How high all of it reaches over a span of x, in a room of that height, metres."""
        if self.crown is None:
            return ceiling if self.height is None else min(self.height, ceiling)
        x, height = self.crown.T
        bends = x[(x > span[0]) & (x < span[1])]
        return float(np.interp([*span, *bends], x, height).min())

    @property
    def length(self) -> float:
        """Of the inner edge, metres; that of the outline, so that its corners map exactly."""
        return float(self.outline[1, 0])

    @property
    def along(self) -> Array:
        """(2,) unit vector to the right."""
        return (self.right - self.left) / self.length

    @property
    def outward(self) -> Array:
        """(2,) unit vector away from the room."""
        x, y = self.along
        return np.array([-y, x])

    @property
    def outer(self) -> tuple[float, float] | None:
        """Where the outer edge begins and ends in x; None for a wall that tapers to a point."""
        edge = self.outline[self.outline[:, 1] == self.thickness, 0]
        return (float(edge.min()), float(edge.max())) if len(edge) >= 2 else None

    def to_plan(self, points: Array) -> Array:
        """Take (..., 2) points of the wall's x and y to the plan; its ends are met exactly."""
        s = points[..., :1] / self.length
        return self.left * (1.0 - s) + self.right * s + points[..., 1:] * self.outward

    def from_plan(self, points: Array) -> Array:
        """Take (..., 2) points of the plan to the wall's x and y."""
        offset = points - self.left
        return np.stack([offset @ self.along, offset @ self.outward], axis=-1)


def walls_of(corners: Array, numbers: Ints, thickness: float) -> tuple[Wall, ...]:
    """The walls around a room.

    Args:
        corners: (N, 2) a simple polygon, counter-clockwise, metres.
        numbers: (N,) the number of the edge from each corner to the next.
        thickness: Outwards from the polygon, metres. A wall is thinner where the room is close on
            its other side too.

    Returns:
        The walls by ascending number.
    """
    turn, following = turns(corners), np.roll(np.arange(len(corners)), -1)
    lengths = np.linalg.norm(corners[following] - corners, axis=1)
    starts = lengths.sum() - np.cumsum(lengths)
    walls = []
    for i, j in enumerate(following):
        # Counter-clockwise edges run from right to left, seen from inside.
        left, right, length = corners[j], corners[i], float(lengths[i])
        wide = footprint(length, turn[j], turn[i], thickness / SHARE)
        wall = Wall(int(numbers[i]), left, right, thickness / SHARE, wide, float(starts[i]))
        thin = min(thickness, SHARE * _free_depth(wall, corners))
        outline = footprint(length, turn[j], turn[i], thin)
        walls.append(replace(wall, thickness=thin, outline=outline))
    return tuple(sorted(walls, key=lambda wall: wall.number))


def _free_depth(wall: Wall, corners: Array) -> float:
    """The least depth behind a wall at which its outline meets an edge of the room, or infinity."""
    back = half_plane(wall.outline, (0.0, -1.0), -NEAR)
    a = wall.from_plan(corners)
    b = np.roll(a, -1, axis=0)
    low, high = back.min(axis=0, initial=np.inf), back.max(axis=0, initial=-np.inf)
    near = ((np.minimum(a, b) <= high) & (np.maximum(a, b) >= low)).all(axis=1)
    a, b = a[near], b[near]
    enter, leave = np.zeros(len(a)), np.ones(len(a))
    for p, q in zip(back, np.roll(back, -1, axis=0), strict=True):
        # Cyrus and Beck 1978: what lies to the left of every side of the outline.
        normal = np.array([q[1] - p[1], p[0] - q[0]])
        from_a, from_b = (a - p) @ normal, (b - p) @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = from_a / (from_a - from_b)
        enter = np.where(from_a > 0.0, np.maximum(enter, crossing), enter)
        leave = np.where(from_b > 0.0, np.minimum(leave, crossing), leave)
        leave = np.where((from_a > 0.0) & (from_b > 0.0), -1.0, leave)
    inside = enter < leave
    ends = [(a + (b - a) * s[:, None])[inside, 1] for s in (enter, leave)]
    return float(np.min(ends, initial=np.inf))


def footprint(length: float, left: float, right: float, thickness: float) -> Array:
    """The outline of a wall between the bisectors of its corners.

    Args:
        length: Of its inner edge, metres.
        left: The angle by which the room's polygon turns at the left end, radians; positive where
            the corner is convex.
        right: The same at the right end.
        thickness: Metres.

    Returns:
        (K, 2) convex, counter-clockwise, first the inner edge (0, 0), (length, 0).
    """
    reach = 3.0 * thickness  # beyond every mitre that the limit allows
    ring = np.array(
        [[-reach, 0.0], [length + reach, 0.0], [length + reach, thickness], [-reach, thickness]]
    )
    for turn, side, end in ((left, -1.0, 0.0), (right, 1.0, length)):
        sine, cosine = np.sin(0.5 * turn), np.cos(0.5 * turn)
        ring = half_plane(ring, (side * cosine, -sine), side * cosine * end)
        if cosine < 1.0 / MITRE_LIMIT and turn > 0.0:
            along = (side * sine, cosine)
            ring = half_plane(ring, along, side * sine * end + MITRE_LIMIT * thickness)
    back = ring[ring[:, 1] > 0.0]
    # The clipped ring starts anywhere: the corner after the inner edge is the rightmost turn.
    first = int(np.flatnonzero((ring[:, 1] > 0.0) & (np.roll(ring[:, 1], 1) == 0.0))[0])
    back = np.roll(ring, -first, axis=0)[: len(back)]
    return np.concatenate([[[0.0, 0.0], [length, 0.0]], back])


def half_plane(ring: Array, normal: tuple[float, float], limit: float) -> Array:
    """The part of a convex ring (K, 2) where ``normal . x <= limit``.

    I. Sutherland and G. Hodgman, Reentrant Polygon Clipping, 1974.
    """
    excess = ring @ np.asarray(normal) - limit
    kept: list[Array] = []
    for i, j in zip(range(len(ring)), np.roll(np.arange(len(ring)), -1), strict=True):
        if excess[i] <= 0.0:
            kept.append(ring[i])
        if excess[i] * excess[j] < 0.0:
            kept.append(ring[i] + (ring[j] - ring[i]) * (excess[i] / (excess[i] - excess[j])))
    distinct = [p for i, p in enumerate(kept) if np.abs(p - kept[i - 1]).max() > 1e-9]
    return np.array(distinct).reshape(-1, 2)
