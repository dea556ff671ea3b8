"""Convex decomposition: as few convex pieces within a tolerance as a greedy search finds."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.topology import distinct_rows
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.components import WELD_M, Component
from openrooms_usd.physics.cutting import cut
from openrooms_usd.physics.hulls import outside_others, quick_hull
from openrooms_usd.physics.merging import Cluster, merged
from openrooms_usd.physics.solid import Solid
from openrooms_usd.physics.surfaces import FEW_CANDIDATES, bisected, is_level

# How far apart hulls are looked at, as shares of their sizes: first at few places, then at more.
SPACINGS: Final = (0.5, 0.25, 0.125, 0.0625)
# Pieces that one component is cut into at most.
MOST_OF_ONE: Final = 64
# Components beyond which neighbours are not looked for: what lies together is one piece.
MAX_JOINED_COMPONENTS: Final = 1_000
# Pieces are not cut across sides that are shorter than this share of the tolerance.
MIN_SIDE_SHARE: Final = 0.5
# What sticks out of another piece by less than this share of the tolerance gets no piece: books
# would tilt on the title of the book below.
PRINT_SHARE: Final = 0.05
# What tolerances grow by where there are too many pieces.
TOLERANCE_GROWTH: Final = 1.5
# How far faces may stick out that look up, where things stand on the solid, metres.
MAX_RISE_M: Final = 2e-3


@dataclass(frozen=True)
class Limits:
    """How far hulls may stick out of a solid.

    Attributes:
        side: To the sides and below, metres.
        up: Where a face looks up along +Z, metres.
    """

    side: float
    up: float

    @classmethod
    def of(cls, tolerance: float) -> "Limits":
        """Those of a tolerance, metres: things that stand on the solid shall not be lifted."""
        return cls(tolerance, min(MAX_RISE_M, tolerance))

    def wider(self) -> "Limits":
        """The next ones: first things may be lifted, then all may be coarse."""
        if self.up < self.side:
            return Limits(self.side, min(self.up * 2.0, self.side))
        return Limits(self.side * TOLERANCE_GROWTH, self.side * TOLERANCE_GROWTH)


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex piece by the points whose hull it is.

    Attributes:
        points: (N, 3) metres.
        contact: Its contact material.
        parts: The names of the parts that it stands for.
        off: How far its hull seems to stick out of the thing, metres.
    """

    points: Array
    contact: str
    parts: tuple[str, ...]
    off: float = np.inf


def convex_decomposition(
    components: Sequence[Component], solid: Solid, tolerance: float, most: int
) -> list[Piece]:
    """Hulls of components, cut where they are too coarse, merged where they are too fine.

    No looked-at point of a hull's surface is farther than the tolerance from the solid, and above a
    level face than `MAX_RISE_M`; but for components that need more than `MOST_OF_ONE` pieces. So
    what is open and wider than twice that stays open.

    Args:
        components: What shall be covered.
        solid: The same as what it fills.
        tolerance: Metres.
        most: The most pieces; where the tolerance needs more, it is widened, for upward faces
            first.
    """
    if len(components) > MAX_JOINED_COMPONENTS:
        return _pooled(components, most)
    limits = Limits.of(tolerance)
    pieces = [
        piece
        for component in components
        for piece in _cut(component, solid, limits, min(most, MOST_OF_ONE))
    ]
    seen = outside_others([piece.points for piece in pieces], PRINT_SHARE * tolerance)
    pieces = [pieces[k] for k in seen]
    while True:
        pieces = _merged(pieces, solid, limits)
        if len(pieces) <= most:
            return pieces
        limits = limits.wider()


def _pooled(components: Sequence[Component], most: int) -> list[Piece]:
    """One piece for what lies in one cell of a grid; the cells grow until there are few enough."""
    centres = np.array([component.corners.mean(axis=(0, 1)) for component in components])
    contacts = list(dict.fromkeys(component.contact for component in components))
    kind = np.array([contacts.index(component.contact) for component in components])
    low, size = centres.min(axis=0), float(np.ptp(centres, axis=0).max())
    count = most
    while True:
        cells = np.floor((centres - low) * (count / max(size, WELD_M))).astype(np.int64)
        rows = np.unique(np.column_stack([kind, cells]), axis=0, return_inverse=True)[1].ravel()
        if rows.max() < max(most, len(contacts)) or count <= 1:
            break
        count //= 2
    pools = [[components[int(k)] for k in np.flatnonzero(rows == n)] for n in range(rows.max() + 1)]
    return [
        Piece(
            np.concatenate([c.corners.reshape(-1, 3) for c in pool]),
            pool[0].contact,
            tuple(dict.fromkeys(c.part for c in pool)),
        )
        for pool in pools
    ]


def _cut(component: Component, solid: Solid, limits: Limits, most: int) -> list[Piece]:
    contact, names = component.contact, (component.part,)
    if component.planes is not None:
        return [Piece(component.corners.reshape(-1, 3), contact, names, 0.0)]

    def off(pieces: Sequence[Array]) -> list[float]:
        points = [piece.reshape(-1, 3) for piece in pieces]
        hulls = [quick_hull(each[distinct_rows(each)[0]])[0] for each in points]
        return protrusions([_faces(hull) for hull in hulls], solid, limits, contact)

    found = cut(component.corners, off, limits.side, limits.side * MIN_SIDE_SHARE, most)
    return [Piece(piece.corners.reshape(-1, 3), contact, names, piece.off) for piece in found]


def _merged(pieces: Sequence[Piece], solid: Solid, limits: Limits) -> list[Piece]:
    found: list[tuple[int, Piece]] = []
    for contact in dict.fromkeys(piece.contact for piece in pieces):
        rows = [k for k, piece in enumerate(pieces) if piece.contact == contact]
        clusters = [Cluster(*quick_hull(pieces[k].points), (k,), pieces[k].off) for k in rows]
        for cluster in _clusters(clusters, solid, limits, contact):
            parts = tuple(dict.fromkeys(p for k in cluster.members for p in pieces[k].parts))
            points = cluster.hull.points
            if len(cluster.members) == 1:
                points = pieces[cluster.members[0]].points
            found.append((cluster.members[0], Piece(points, contact, parts, cluster.off)))
    return [piece for _, piece in sorted(found, key=lambda pair: pair[0])]


def _clusters(clusters: list[Cluster], solid: Solid, limits: Limits, contact: str) -> list[Cluster]:
    def may(points: Array) -> Mask:
        return _fits(points, limits.side, solid, contact)

    def off(faces: Sequence[Array]) -> list[float]:
        return protrusions(faces, solid, limits, contact)

    return merged(clusters, limits.side, may, off)


def protrusions(faces: Sequence[Array], solid: Solid, limits: Limits, contact: str) -> list[float]:
    """How far sets of faces seem to lie outside the solid, metres.

    Places on the faces are looked at, first few and then more where none was too far. What lifts
    counts by the ratio of the limits more.

    Args:
        faces: (M, 3, 3) triangles of each, counter-clockwise from outside; at least one set.
        solid: What they stand for.
        limits: What is too far.
        contact: Their contact material: other surfaces do not count unless the hull is inside them.
    """
    found = np.zeros(len(faces))
    sizes = np.array([_size(each) for each in faces])
    corners = np.concatenate(faces)
    group = np.repeat(np.arange(len(faces)), [len(each) for each in faces])
    for share in SPACINGS:
        left = found[group] <= limits.side
        corners, of = bisected(corners[left], np.maximum(sizes * share, limits.side)[group[left]])
        if not len(corners):
            break
        group = group[left][of]
        off, near = _off(corners, solid, limits, contact)
        np.maximum.at(found, group, off)
        # What is within the limits as a whole need not be looked at more closely.
        rest = ~near
        corners, group = corners[rest], group[rest]
    return [float(value) for value in found]


def _size(corners: Array) -> float:
    return float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0))) if len(corners) else 0.0


def _off(corners: Array, solid: Solid, limits: Limits, contact: str) -> tuple[Array, Mask]:
    """(N,) how far the middles of triangles lie outside the solid; what lifts counts more.

    Also (N,) whether all of a triangle is certain to be within the limits.
    """
    points, surface = corners.mean(axis=1), solid.surface(contact)
    level = is_level(corners)
    distance, triangle = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    # Where nothing is lifted it does not matter which of two near triangles is nearer.
    for rows, candidates in ((level, FEW_CANDIDATES), (~level, 1)):
        near = surface.near(points[rows], candidates)
        distance[rows], triangle[rows] = near.distance, near.triangle
    # Above a level face, a level face would lift what stands there.
    lifts = level & surface.level[triangle]
    weight = np.where(lifts, limits.side / limits.up, 1.0)
    off = _outside(points, distance, limits.side / weight, solid, contact) * weight
    whole = surface.farthest(corners, triangle) <= np.where(level, limits.up, limits.side)
    return off, whole


def _outside(points: Array, near: Array, limits: Array, solid: Solid, contact: str) -> Array:
    """(N,) how far points lie outside the solid, exactly where that is more than a limit."""
    off = near.copy()
    rest = np.flatnonzero(off > limits)
    inside = solid.inside(points[rest])
    off[rest[inside]] = 0.0
    rest = rest[~inside]
    off[rest] = solid.surface(contact).nearest(points[rest], limits[rest], decided=True).distance
    return off


def _faces(hull: TriangleMesh) -> Array:
    return np.asarray(hull.points[hull.triangles])


def _fits(points: Array, limit: float, solid: Solid, contact: str) -> Mask:
    """(N,) whether each point is within a limit of the solid."""
    near, limits = solid.surface(contact).near(points).distance, np.full(len(points), limit)
    return np.asarray(_outside(points, near, limits, solid, contact) <= limit)
