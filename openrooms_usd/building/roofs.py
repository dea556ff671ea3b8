"""Ceilings that follow the tops of walls: under a gable, or leaning from a high wall to a low one.

The line along which the walls meet the ceiling is given; between it the ceiling is stretched. No
fold sags: over two gables the ridge runs from peak to peak. Above it everything is filled up to a
level, so what reaches up to the ceiling ends inside of it, and no light comes in.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.faces import Face, level, polyhedron
from openrooms_usd.building.shell import slab, wall_tops
from openrooms_usd.building.walls import Wall
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.polygons import triangulated

# What is nearer than this to a wall's inner edge is on it, metres.
_ON_WALL_M: Final = 1e-3
# A fold that sags by less is left, metres.
_SAG_M: Final = 1e-6


def crowned(walls: Sequence[Wall], line: Array) -> tuple[Wall, ...]:
    """The walls of an outline, each with its part of the line where they meet the ceiling.

    Args:
        walls: All of the outline.
        line: (M, 3) in order around the room: every corner of it, and where a top bends; metres.
    """
    return tuple(replace(wall, crown=_crown(wall, line)) for wall in walls)


def _crown(wall: Wall, line: Array) -> Array:
    x, y = wall.from_plan(line[:, :2]).T
    x = np.where(np.abs(x) < _ON_WALL_M, 0.0, x)
    x = np.where(np.abs(x - wall.length) < _ON_WALL_M, wall.length, x)
    on = (np.abs(y) < _ON_WALL_M) & (x >= 0.0) & (x <= wall.length)
    found, first = np.unique(x[on], return_index=True)
    return np.column_stack([found, line[on, 2][first]])


def roof_line(walls: Sequence[Wall], corners: Array) -> Array:
    """(M, 3) where walls with crowns meet the ceiling, counter-clockwise; metres.

    Args:
        walls: All of an outline.
        corners: (N, 2) the room, counter-clockwise, metres.
    """
    starts = {tuple(wall.right.tolist()): wall for wall in walls}
    found: list[Array] = []
    for corner in corners:
        wall = starts[tuple(corner.tolist())]
        assert wall.crown is not None
        x, heights = wall.crown[:0:-1].T  # edges run from right to left, seen from inside
        plan = wall.to_plan(np.column_stack([x, np.zeros(len(x))]))
        found.append(np.column_stack([plan, heights]))
    return np.concatenate(found)


def stretched(line: Array) -> Array:
    """(K, 3, 3) triangles between a line around a room, counter-clockwise from above.

    Two that sag between them are turned: their common side becomes the other diagonal, as long as
    one does.
    """
    number = {tuple(place): i for i, place in enumerate(line[:, :2].tolist())}
    faces = [[number[tuple(p)] for p in ring] for ring in triangulated(line[:, :2]).tolist()]
    while (fold := _sagging(faces, line)) is not None:
        i, j, (a, b, c, d) = fold
        faces[i], faces[j] = [c, a, d], [d, b, c]
    return np.asarray(line[np.array(faces)])


def _sagging(
    faces: Sequence[Sequence[int]], line: Array
) -> tuple[int, int, tuple[int, int, int, int]] | None:
    """Two faces over a convex quadrilateral that sag: their numbers, the common side, the rest."""
    sides: dict[tuple[int, int], tuple[int, int]] = {}
    for i, face in enumerate(faces):
        for k in range(3):
            a, b, c = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            sides[a, b] = i, c
            if (b, a) in sides:
                j, d = sides[b, a]
                if _rise(line[a], line[b], line[c], line[d]) > _SAG_M:
                    return i, j, (a, b, c, d)
    return None


def _rise(a: Array, b: Array, c: Array, d: Array) -> float:
    """How much higher c d is than a b where they cross in the plan; 0 where they do not."""
    along, across, off = b - a, d - c, c - a
    cross = along[0] * across[1] - along[1] * across[0]
    if abs(cross) < _ON_WALL_M**2:
        return 0.0
    s = (off[0] * across[1] - off[1] * across[0]) / cross
    t = (off[0] * along[1] - off[1] * along[0]) / cross
    if not (_SAG_M < s < 1.0 - _SAG_M and _SAG_M < t < 1.0 - _SAG_M):
        return 0.0
    return float(c[2] + t * across[2] - a[2] - s * along[2])


def ceiling_solid(walls: Sequence[Wall], corners: Array, height: float, thickness: float) -> Mesh:
    """The ceiling of a room, over it and over its walls.

    Args:
        walls: Those of the outline, with crowns or without, and others.
        corners: (N, 2) the room, counter-clockwise, metres.
        height: Floor to ceiling, at its highest, metres.
        thickness: There, and how far it reaches out, metres.

    Returns:
        A slab; where walls have crowns closed solids, one over the room and one over each wall.
    """
    top = height + thickness
    outline = [wall for wall in walls if wall.crown is not None]
    if not outline:
        return slab(corners, thickness, height, top)
    over = [_filled(wall_tops(wall), top) for wall in outline]
    return joined([_filled(list(stretched(roof_line(outline, corners))), top), *over])


def _filled(faces: Sequence[Array], top: float) -> Mesh:
    """The solid between faces, counter-clockwise from above, and a level."""
    solid: list[Face] = []
    sides: dict[tuple[tuple[float, ...], tuple[float, ...]], Face] = {}
    for face in faces:
        solid += [(face[::-1], face[::-1, :2]), level(face[:, :2], top, up=True)]
        for a, b in zip(face, np.roll(face, -1, axis=0), strict=True):
            length = float(np.linalg.norm((b - a)[:2]))
            corners = np.array([a, b, [*b[:2], top], [*a[:2], top]])
            st = np.column_stack([[0.0, length, length, 0.0], corners[:, 2]])
            one, other = tuple(a.tolist()), tuple(b.tolist())
            if sides.pop((other, one), None) is None:
                sides[one, other] = corners, st
    return polyhedron([*solid, *sides.values()])
