"""Tiles and boards on a wall: a thin solid with holes, mitred with that of the next wall."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.faces import Face, polyhedron
from openrooms_usd.building.mouldings import EMBED_M
from openrooms_usd.building.shell import Hole
from openrooms_usd.building.walls import Wall
from openrooms_usd.geometry.mesh import Mesh

_LEAST_M: Final = 1e-3


def cladding(
    wall: Wall,
    span: tuple[float, float],
    heights: tuple[float, float],
    depth: float,
    holes: Sequence[Hole] = (),
    turns: tuple[float, float] = (0.0, 0.0),
) -> list[Mesh]:
    """What covers a part of a wall, around its openings.

    Args:
        wall: Its place in the plan.
        span: From where to where in the wall's x, metres.
        heights: Lower and upper edge above the floor, metres.
        depth: How far it stands out, metres.
        holes: What it leaves free, in the wall's x and z.
        turns: The tangents of half the angles by which the room turns at the left and the right
            end; positive where the corner is convex. There neighbours meet in mitres.

    Returns:
        Closed solids side by side: rectangles that the holes leave, with texture coordinates that
        run on over all of them, along the wall and up.
    """
    low, high = max(span[0], 0.0), min(span[1], wall.length)
    bottom, top = heights
    xs = _between(low, high, [x for hole in holes for x in (hole.left, hole.right)])
    made = []
    for x0, x1 in pairwise(xs):
        middle = 0.5 * (x0 + x1)
        taken = sorted((h.bottom, h.top) for h in holes if h.left < middle < h.right)
        begin = bottom
        for z0, z1 in [*taken, (top, top)]:
            if min(z0, top) - begin > _LEAST_M:
                left = depth * turns[0] if x0 <= _LEAST_M else 0.0
                right = depth * turns[1] if x1 >= wall.length - _LEAST_M else 0.0
                made.append(_piece(wall, (x0, x1), (begin, min(z0, top)), depth, (left, right)))
            begin = max(begin, z1)
    return made


def _between(low: float, high: float, inner: Sequence[float]) -> list[float]:
    kept = [low, *sorted(x for x in inner if low < x < high), high]
    return [kept[0], *(b for a, b in pairwise(kept) if b - a > _LEAST_M)]


def _piece(
    wall: Wall,
    x: tuple[float, float],
    z: tuple[float, float],
    depth: float,
    mitres: tuple[float, float],
) -> Mesh:
    """A solid before the wall; its front is shorter at convex corners, longer at concave ones."""
    back, front = EMBED_M, -depth
    plan = np.array(
        [[x[0] + mitres[0], front], [x[1] - mitres[1], front], [x[1], back], [x[0], back]]
    )
    sides = [_side(wall, plan[i], plan[(i + 1) % 4], z) for i in range(4)]
    caps = [_cap(wall, plan, z[1], up=True), _cap(wall, plan, z[0], up=False)]
    return polyhedron([*sides, *caps])


def _side(wall: Wall, a: Array, b: Array, z: tuple[float, float]) -> Face:
    ends = np.array([a, b, b, a])
    level = np.array([z[0], z[0], z[1], z[1]])
    # Across the thickness of the tiles the pattern runs on.
    s = wall.start + ends[:, 0] + (0.0 if a[1] == b[1] else ends[:, 1])
    return np.column_stack([wall.to_plan(ends), level]), np.stack([s, level], axis=1)


def _cap(wall: Wall, plan: Array, height: float, *, up: bool) -> Face:
    ring = plan if up else plan[::-1]
    st = np.stack([wall.start + ring[:, 0], height + ring[:, 1]], axis=1)
    return np.column_stack([wall.to_plan(ring), np.full(4, height)]), st
