"""Floors and walls that are given as triangle meshes: outlines, and the holes in them."""

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array, Ints

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

Faces = list[Ints]

# Points nearer to each other than this are welded, metres: single precision in a room.
_WELD_M: Final = 1e-5
# Points of one face of a wall lie within this of its plane, metres; and slabs thinner than this are
# sheets, which the parametric export makes to be seen.
_FLAT_M: Final = 2e-3
# How far the block that fills a corner reaches beyond a wall's end, in thicknesses of the wall.
_MAX_BLOCK_DEPTHS: Final = 2.0
# What is narrower than twice this is not a hole, metres.
_SLIVER_M: Final = 0.01
# Holes smaller than this are noise of the triangulation, square metres; passages are 1 or 2.
_MIN_HOLE_M2: Final = 0.05
# The part of its bounding box that a hole covers at least, to be a rectangle.
_MIN_RECTANGLE_SHARE: Final = 0.9


class Hole(NamedTuple):
    """A rectangle that is missing in a wall, in the wall's x and y, metres."""

    left: float
    right: float
    bottom: float
    top: float


def split(counts: Ints, indices: Ints, points: int) -> Faces | None:
    """The faces of a mesh, each its points; None where the numbers make no mesh.

    Args:
        counts: How many corners each face has.
        indices: The corners' points, face after face.
        points: How many points there are.
    """
    sound = counts.sum() == len(indices) and counts.min() >= 3
    if not sound or indices.min() < 0 or indices.max() >= points:
        return None
    return list(np.split(indices, np.cumsum(counts)[:-1]))


def floor_outline(points: Array, faces: Faces) -> Array | None:
    """The corners of a floor that is given as a slab.

    A slab with a thickness lies under the walls too, whose thickness it has: its outline is moved
    inwards by that much.

    Args:
        points: (N, 3) the mesh's points, metres.
        faces: Its faces.

    Returns:
        (K, 3) the corners in order, or None when its upper face is not a polygon.
    """
    axis = int(np.argmin(np.ptp(points, axis=0)))
    corners = rim(points, faces, axis)
    if corners is None:
        corners = _largest(points, faces, axis)
    depth = float(np.ptp(points[:, axis]))
    if corners is None or depth <= _FLAT_M:
        return corners
    plan = [i for i in range(3) if i != axis]
    moved = corners.copy()
    moved[:, plan] = _inwards(corners[:, plan], depth)
    return moved


def rim(points: Array, faces: Faces, axis: int) -> Array | None:
    """(K, 3) the single simple ring around the upper face of a slab; None when there is none."""
    upper = points[:, axis] > points[:, axis].max() - _WELD_M
    welded = np.unique(np.round(points / _WELD_M), axis=0, return_inverse=True)[1].ravel()
    edges: Counter[tuple[int, int]] = Counter()
    for face in faces:
        if upper[face].all():
            ring = welded[face].tolist()
            edges.update(pairwise([*ring, ring[0]]))
    after = {a: b for a, b in edges if not edges[b, a] and a != b}
    ring = _ring(after)
    where = {int(w): i for i, w in reversed(list(enumerate(welded)))}
    return None if ring is None else points[[where[w] for w in ring]]


def _ring(after: dict[int, int]) -> list[int] | None:
    """The only cycle of a successor map; None when there is none, or several."""
    if len(after) < 3:
        return None
    start = min(after)
    ring, point = [start], after[start]
    while point != start and point in after and len(ring) <= len(after):
        ring.append(point)
        point = after[point]
    return ring if point == start and len(ring) == len(after) else None


def _largest(points: Array, faces: Faces, axis: int) -> Array | None:
    """(K, 3) the outline of the largest part of an upper face that is not one simple ring."""
    import shapely

    plan, top = [i for i in range(3) if i != axis], points[:, axis].max()
    upper = [face for face in faces if (points[face, axis] > top - _FLAT_M).all()]
    whole = _union(points[:, plan], upper)
    parts = [part for part in shapely.get_parts(whole) if part.geom_type == "Polygon"]
    if not parts or max(part.area for part in parts) <= 0.0:
        return None
    largest = max(parts, key=lambda part: part.area)
    ring = shapely.get_coordinates(largest.exterior)[:-1]
    corners = np.full((len(ring), 3), top)
    corners[:, plan] = ring
    return corners


def _union(points: Array, faces: Faces) -> "BaseGeometry":
    """The area that faces cover of a plane: points (N, 2)."""
    import shapely

    rings = [shapely.Polygon(points[face]) for face in faces]
    return shapely.union_all([ring for ring in rings if ring.is_valid], grid_size=_WELD_M)


def _inwards(corners: Array, depth: float) -> Array:
    """A polygon (N, 2) with every edge moved inwards, and its corners where they were."""
    after = np.roll(corners, -1, axis=0)
    area = float((corners[:, 0] * after[:, 1] - after[:, 0] * corners[:, 1]).sum())
    along = after - corners
    along /= np.maximum(np.linalg.norm(along, axis=1), _WELD_M)[:, None]
    inward = np.sign(area) * np.column_stack([-along[:, 1], along[:, 0]])
    before = np.roll(inward, 1, axis=0)
    # The point on both moved edges; where these run back on each other, off one of them.
    turn = np.maximum(1.0 + (inward * before).sum(axis=1), 0.1)
    return np.asarray(corners + depth * (inward + before) / turn[:, None])


def is_flat(points: Array) -> bool:
    """Whether a wall's points (N, 3) lie on one plane, or on the two faces of a slab."""
    z = np.sort(points[:, 2])
    steps = np.diff(z)
    return bool((steps > _FLAT_M).sum() <= 1 and np.ptp(z) <= steps.max(initial=0.0) + 2 * _FLAT_M)


def span(points: Array) -> tuple[float, float]:
    """Where a wall begins and ends in its x, metres.

    The mesh export fills the corners of the room with blocks that are one with a wall and reach
    beyond one of its ends, about as far as it is thick. The middle of the wall is at x = 0.
    """
    left, right = float(points[:, 0].min()), float(points[:, 0].max())
    beyond, half = abs(left + right), min(-left, right)
    if half > 0.0 and _FLAT_M < beyond < _MAX_BLOCK_DEPTHS * float(np.ptp(points[:, 2])):
        return -half, half
    return left, right


def missing(points: Array, faces: Faces, ends: tuple[float, float]) -> "list[Polygon]":
    """What the face of a flat wall leaves open of its rectangle.

    Args:
        points: (N, 3) in the wall's frame, whose plane is z = 0, metres.
        faces: The faces.
        ends: Where the wall begins and ends in its x, metres.

    Returns:
        Polygons in the wall's x and y, from left to right.
    """
    import shapely

    depth = np.abs(points[:, 2])
    front = [face for face in faces if (depth[face] < depth.min() + _FLAT_M).all()]
    bottom, top = points[:, 1].min(), points[:, 1].max()
    rest = shapely.box(ends[0], bottom, ends[1], top).difference(_union(points[:, :2], front))
    # Without the slivers that rounding leaves along the wall's ends.
    rest = rest.buffer(-_SLIVER_M).buffer(_SLIVER_M, join_style="mitre")
    parts = [part for part in shapely.get_parts(rest) if part.area > _MIN_HOLE_M2]
    return sorted(parts, key=lambda part: tuple(part.bounds))


def holes(parts: "Sequence[Polygon]", top: float) -> list[Hole]:
    """The rectangles among what is missing in a wall.

    Args:
        parts: What is missing. Where that is open at the top, the wall is lower there.
        top: The wall's top in its y, metres.
    """
    found = []
    for part in parts:
        left, low, right, high = part.bounds
        box = (right - left) * (high - low)
        if high < top - _SLIVER_M and part.area > _MIN_RECTANGLE_SHARE * box:
            found.append(Hole(left, right, low, high))
    return found


def lowered(
    parts: "Sequence[Polygon]", ends: tuple[float, float], bottom: float, top: float
) -> Array:
    """(K, 3) the corners of a wall that is not as high everywhere; none of a rectangle."""
    import shapely

    cuts = [part for part in parts if part.bounds[3] >= top - _SLIVER_M]
    whole = shapely.box(ends[0], bottom, ends[1], top).difference(shapely.union_all(cuts))
    if not cuts or not isinstance(whole, shapely.Polygon):
        return np.empty((0, 3))
    return np.insert(shapely.get_coordinates(whole.exterior)[:-1], 2, 0.0, axis=1)
