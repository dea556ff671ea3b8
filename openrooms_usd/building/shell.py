"""The closed shell of a room: one solid for each wall, a slab below and a slab above.

Light enters through the holes alone. The slabs reach under and over the walls, so that no seam
between two solids lies open to a ray from inside.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.faces import Face, level, polyhedron, prism, upright
from openrooms_usd.building.walls import MITRE_LIMIT, Wall
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.polygons import grown, triangulated


@dataclass(frozen=True)
class Hole:
    """A rectangle through a wall, in the wall's x and z, metres.

    A hole whose bottom is 0 stands on the floor.
    """

    left: float
    right: float
    bottom: float
    top: float

    @property
    def ring(self) -> Array:
        """(4, 2) corners, counter-clockwise seen from inside."""
        return np.array(
            [
                [self.left, self.bottom],
                [self.right, self.bottom],
                [self.right, self.top],
                [self.left, self.top],
            ]
        )


def wall_solid(wall: Wall, height: float, holes: Sequence[Hole] = ()) -> Mesh:
    """A wall with its holes as one closed solid.

    Args:
        wall: Its place in the plan.
        height: Floor to ceiling, metres; a crown of its own says otherwise.
        holes: Rectangles through it, inside both its inner and its outer edge, apart from each
            other and below the ceiling.

    Returns:
        The solid in the room's frame: x and y of the plan, z up from the floor. Its texture
        coordinates run along the walls to the right and up.
    """
    crown = np.array([[0.0, height], [wall.length, height]]) if wall.crown is None else wall.crown
    faces = [
        *_front(wall, crown, holes),
        *_ends(wall, crown),
        *((ring, ring[:, :2]) for ring in _tops(wall, crown)),
        *(level(ring, 0.0, up=False) for ring in cut_apart(wall, _standing(holes))),
        *(face for hole in holes for face in _reveals(hole, wall.thickness)),
    ]
    return polyhedron([(_to_room(wall, corners), st) for corners, st in faces])


def _to_room(wall: Wall, corners: Array) -> Array:
    return np.column_stack([wall.to_plan(corners[:, :2]), corners[:, 2]])


def _front(wall: Wall, crown: Array, holes: Sequence[Hole]) -> Iterator[Face]:
    """The inner face and, where the wall has one, the outer face, both with their holes."""
    shift = np.array([wall.start, 0.0])
    for ring in _with_holes(0.0, wall.length, crown, holes):
        yield np.insert(ring, 1, 0.0, axis=1), ring + shift
    if wall.outer:
        for ring in _with_holes(*wall.outer, crown, holes):
            back = ring[::-1]
            yield np.insert(back, 1, wall.thickness, axis=1), back + shift


def _with_holes(left: float, right: float, crown: Array, holes: Sequence[Hole]) -> list[Array]:
    """Counter-clockwise faces in x and z of what is below a crown, without its holes."""
    notches = [hole.ring[[0, 3, 2, 1]] for hole in _standing(holes)]
    top = [right, *(x for x in _bends(crown)[::-1] if left < x < right), left]
    corners = np.array(
        [[left, 0.0], [right, 0.0], *zip(top, np.interp(top, *crown.T), strict=True)]
    )
    if not holes:
        return [corners]
    outline = np.concatenate([corners[:1], *notches, corners[1:]])
    return list(triangulated(outline, tuple(hole.ring for hole in holes if hole.bottom > 0.0)))


def _bends(crown: Array) -> list[float]:
    """The x at which a crown bends; beyond its ends it is level."""
    rises = [0.0, *(np.diff(crown[:, 1]) / np.diff(crown[:, 0])).tolist(), 0.0]
    return [float(x) for x, (a, b) in zip(crown[:, 0], pairwise(rises), strict=True) if a != b]


def _edge(a: Array, b: Array, crown: Array) -> Array:
    """(K, 2) an edge of an outline from a to before b, with a corner wherever the crown bends."""
    (x0, y0), (x1, y1) = a, b
    bends = [x for x in _bends(crown) if (x - x0) * (x - x1) < 0.0]
    between = [(x, y0 + (x - x0) / (x1 - x0) * (y1 - y0)) for x in bends]
    return np.array([a, *(between if x0 < x1 else between[::-1])])


def _standing(holes: Sequence[Hole]) -> list[Hole]:
    """The holes that stand on the floor, from left to right."""
    return sorted((hole for hole in holes if hole.bottom == 0.0), key=lambda hole: hole.left)


def _ends(wall: Wall, crown: Array) -> Iterator[Face]:
    """The faces at the mitres: over every edge of the outline but the inner and the outer one."""
    for a, b in pairwise([*wall.outline[1:], wall.outline[0]]):
        if not a[1] == b[1] == wall.thickness:
            top = np.concatenate([[b], _edge(a, b, crown)[::-1]])
            ring = np.concatenate([[a, b], top])
            heights = np.array([0.0, 0.0, *np.interp(top[:, 0], *crown.T)])
            along = np.linalg.norm(ring - a, axis=1)
            yield np.column_stack([ring, heights]), np.column_stack([along, heights])


def wall_tops(wall: Wall) -> list[Array]:
    """The flat upper faces of a wall with a crown: (K, 3) each, counter-clockwise from above."""
    assert wall.crown is not None
    return [_to_room(wall, ring) for ring in _tops(wall, wall.crown)]


def _tops(wall: Wall, crown: Array) -> list[Array]:
    """The outline at the height of a crown, cut apart where that bends."""
    following = np.roll(wall.outline, -1, axis=0)
    edges = [_edge(a, b, crown) for a, b in zip(wall.outline, following, strict=True)]
    ring = np.concatenate(edges)
    ring = np.column_stack([ring, np.interp(ring[:, 0], *crown.T)])
    spans = pairwise([-np.inf, *_bends(crown), np.inf])
    pieces = [ring[(ring[:, 0] >= low) & (ring[:, 0] <= high)] for low, high in spans]
    return [piece for piece in pieces if len(piece) >= 3 and np.ptp(piece[:, 0]) > 0.0]


def cut_apart(wall: Wall, holes: Sequence[Hole]) -> list[Array]:
    """The outline of a wall, cut apart over the whole width of some holes.

    Returns:
        Convex counter-clockwise (K, 2) rings in the wall's x and y, from left to right.
    """
    rest, pieces = wall.outline, []
    for hole in sorted(holes, key=lambda hole: hole.left):
        left, right = np.array([hole.left, 0.0]), np.array([hole.right, 0.0])
        far = np.array([0.0, wall.thickness])
        last = int(np.flatnonzero(rest[:, 1] == wall.thickness)[-1])  # left end of the outer edge
        pieces.append(np.concatenate([rest[:1], [left, left + far], rest[last:]]))
        rest = np.concatenate([[right], rest[1:last], [right + far]])
    return [*pieces, rest]


def _reveals(hole: Hole, thickness: float) -> Iterator[Face]:
    """The sides of a hole through the wall; a hole on the floor has the slab as its threshold."""
    x, y = (hole.left, hole.right), (0.0, thickness)
    plan = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    yield upright(plan[0], plan[3], hole.bottom, hole.top)
    yield upright(plan[2], plan[1], hole.bottom, hole.top)
    yield level(plan, hole.top, up=False)
    if hole.bottom > 0.0:
        yield level(plan, hole.bottom, up=True)


def slab(corners: Array, margin: float, bottom: float, top: float) -> Mesh:
    """A closed slab under or over a room and its walls.

    Args:
        corners: (N, 2) the room's polygon, metres.
        margin: How far it reaches beyond the polygon, metres.
        bottom: Height of its lower face, metres.
        top: Height of its upper face, metres.

    Returns:
        The solid, with texture coordinates in the plan's x and y.
    """
    return prism(grown(corners, margin, MITRE_LIMIT), bottom, top)
