"""The fewest convex pieces within a tolerance that a greedy search finds."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.components import Component
from openrooms_usd.physics.cutting import cut
from openrooms_usd.physics.hulls import quick_hull
from openrooms_usd.physics.merging import Cluster, merged
from openrooms_usd.physics.solid import Solid

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

# How closely a hull is looked at, as a share of what its sides may stick out.
RESOLUTION: Final = 0.4
# Places of a hull that are looked at before all of it is.
LOOKS: Final = 12
# Pieces are not cut across sides that are shorter than this share of the tolerance.
SHORTEST: Final = 0.5
# What tolerances grow by where there are too many pieces.
RELAXED: Final = 1.5
# How far faces may stick out that look up, where things stand on the solid, metres.
RISE: Final = 2e-3
# Faces look up whose unit normal's Z is more.
UP: Final = 0.7


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
        return cls(tolerance, min(RISE, tolerance))

    def wider(self) -> "Limits":
        """The next ones: first things may be lifted, then all may be coarse."""
        if self.up < self.side:
            return Limits(self.side, min(self.up * 2.0, self.side))
        return Limits(self.side * RELAXED, self.side * RELAXED)

    def at(self, corners: Array) -> Array:
        """(M,) the limit of each of (M, 3, 3) triangles that are counter-clockwise from outside."""
        a, b, c = np.moveaxis(corners, 1, 0)
        normals = np.cross(b - a, c - a)
        up = normals[:, 2] > UP * np.linalg.norm(normals, axis=1)
        return np.where(up, self.up, self.side)


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex piece by the points whose hull it is.

    Attributes:
        points: (N, 3) metres.
        contact: Its contact material.
        parts: The names of the parts that it stands for.
        bound: How far its hull sticks out of the thing at most, metres; infinite where unknown.
    """

    points: Array
    contact: str
    parts: tuple[str, ...]
    bound: float = np.inf


def fewest(
    components: Sequence[Component], solid: Solid, tolerance: float, most: int
) -> list[Piece]:
    """Hulls of components, cut where they are too coarse, merged where they are too fine.

    Any point of a hull's surface is within the tolerance of the solid, and of a face that looks up
    within `RISE`. So what is open and wider than twice that stays open.

    Args:
        components: What shall be covered.
        solid: The same as what it fills.
        tolerance: Metres.
        most: The most pieces; where the tolerance needs more, it is widened, for upward faces
            first.
    """
    limits = Limits.of(tolerance)
    pieces = [
        piece
        for contact in dict.fromkeys(component.contact for component in components)
        for piece in _cut([c for c in components if c.contact == contact], solid, limits, most)
    ]
    while True:
        pieces = _merged(pieces, solid, limits)
        if len(pieces) <= most:
            return pieces
        limits = limits.wider()


def _cut(components: Sequence[Component], solid: Solid, limits: Limits, most: int) -> list[Piece]:
    contact = components[0].contact

    def accepts(pieces: Sequence[Array]) -> list[float]:
        hulls = [quick_hull(np.unique(piece.reshape(-1, 3), axis=0))[0] for piece in pieces]
        return protrusions([_faces(hull) for hull in hulls], solid, limits, contact)

    surfaces = [component.corners for component in components]
    # Merging makes some of them one again: hence more than there may be in the end.
    found = cut(surfaces, accepts, limits.side * SHORTEST, 4 * max(most, len(surfaces)))
    return [
        Piece(piece.corners.reshape(-1, 3), contact, (components[piece.source].part,), piece.bound)
        for piece in found
    ]


def _merged(pieces: Sequence[Piece], solid: Solid, limits: Limits) -> list[Piece]:
    found: list[tuple[int, Piece]] = []
    for contact in dict.fromkeys(piece.contact for piece in pieces):
        rows = [k for k, piece in enumerate(pieces) if piece.contact == contact]
        clusters = [Cluster(*quick_hull(pieces[k].points), (k,), pieces[k].bound) for k in rows]
        for cluster in _clusters(clusters, solid, limits, contact):
            parts = tuple(dict.fromkeys(p for k in cluster.members for p in pieces[k].parts))
            points = cluster.hull.points
            if len(cluster.members) == 1:
                points = pieces[cluster.members[0]].points
            found.append((cluster.members[0], Piece(points, contact, parts, cluster.bound)))
    return [piece for _, piece in sorted(found, key=lambda pair: pair[0])]


def _clusters(clusters: list[Cluster], solid: Solid, limits: Limits, contact: str) -> list[Cluster]:
    def may(points: Array) -> Bools:
        return _fits(points, np.full(len(points), limits.side), solid, contact)

    def accepts(faces: Sequence[Array]) -> list[float]:
        return protrusions(faces, solid, limits, contact)

    return merged(clusters, 2.0 * limits.side, may, accepts)


def protrusions(faces: Sequence[Array], solid: Solid, limits: Limits, contact: str) -> list[float]:
    """How far sets of faces lie outside the solid at most; infinite where too far.

    Args:
        faces: (M, 3, 3) triangles of each, counter-clockwise from outside; at least one set.
        solid: What they stand for.
        limits: What is too far.
        contact: Their contact material: other surfaces do not count unless the hull is inside them.
    """
    largest = [_largest(corners) for corners in faces]
    shown = np.concatenate(largest)
    fits = _fits(shown.mean(axis=1), limits.at(shown), solid, contact)
    found = np.zeros(len(faces))
    found[np.repeat(np.arange(len(faces)), [len(corners) for corners in largest])[~fits]] = np.inf
    rows = [k for k in range(len(faces)) if found[k] == 0.0 and len(faces[k])]
    if rows:
        corners = np.concatenate([faces[k] for k in rows])
        groups = np.repeat(np.arange(len(rows)), [len(faces[k]) for k in rows])
        found[rows] = solid.within(
            corners, groups, limits.at(corners), RESOLUTION * limits.side, contact
        )
    return [float(value) for value in found]


def _faces(hull: TriangleMesh) -> Array:
    return np.asarray(hull.points[hull.triangles])


def _largest(corners: Array) -> Array:
    """The largest triangles: where a hull that is too coarse mostly is so."""
    a, b, c = np.moveaxis(corners, 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.asarray(corners[np.argsort(-areas, kind="stable")[:LOOKS]])


def _fits(points: Array, limits: Array, solid: Solid, contact: str) -> Bools:
    """(N,) whether each point is within its limit of the solid."""
    fine = solid.surface(contact).near(points).distance <= limits
    rest = np.flatnonzero(~fine)
    fine[rest] = solid.inside(points[rest])
    return np.asarray(fine)
