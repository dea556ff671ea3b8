"""Convex pieces of an upright wall with rectangular holes, exactly."""

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.physics.hulls import volume

if TYPE_CHECKING:
    from shapely import Geometry

Array = NDArray[np.float64]

# Corners that lie nearer to each other are on one line, metres.
_SAME_LINE_M: Final = 1e-6
# The pieces are right when their volumes add up to the wall's, but for this part of it.
_MISSING_VOLUME_SHARE: Final = 1e-3


def panel_pieces(mesh: TriangleMesh) -> list[TriangleMesh]:
    """Cut a wall apart into the convex pieces that are left around its holes.

    Args:
        mesh: A closed solid: an upright prism over a convex outline, such as a wall with mitred
            ends, with rectangular holes through it; Z up, metres.

    Returns:
        Its pieces from one end to the other; none where it is no such solid.
    """
    frame = _frame(mesh)
    if frame is None:
        return []
    local = mesh.points @ frame
    outline = _convex(local[:, :2])
    face = _face(local, mesh)
    if not _is_rectangular(face):
        return []
    pieces = [_prism(outline, *rectangle) for rectangle in _rectangles(face)]
    solids = [_turned(piece, frame) for piece in pieces if piece is not None]
    whole = volume(mesh)
    return solids if abs(sum(map(volume, solids)) - whole) <= _MISSING_VOLUME_SHARE * whole else []


def _frame(mesh: TriangleMesh) -> Array | None:
    """(3, 3) columns: along the wall, off its largest upright face, up."""
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    doubled = np.cross(b - a, c - a)
    doubled = doubled[np.abs(doubled[:, 2]) <= _SAME_LINE_M * np.linalg.norm(doubled, axis=1)]
    if not len(doubled):
        return None
    units = unit(doubled)
    same = np.linalg.norm(units[:, None] - units, axis=2) < _SAME_LINE_M
    areas = same @ np.linalg.norm(doubled, axis=1)
    normal = units[int(np.round(areas, 9).argmax())]
    return np.column_stack([np.cross(normal, [0.0, 0.0, 1.0]), normal, [0.0, 0.0, 1.0]])


def _face(local: Array, mesh: TriangleMesh) -> "Geometry":
    """The wall as it is seen from its largest face."""
    import shapely

    a, b, c = np.moveaxis(local[mesh.triangles], 1, 0)
    normals = unit(np.cross(b - a, c - a))
    facing = normals[:, 1] > 1.0 - _SAME_LINE_M
    rings = np.round(local[mesh.triangles[facing]][:, :, [0, 2]], 6)
    return shapely.union_all(shapely.polygons(rings), grid_size=_SAME_LINE_M)


def _is_rectangular(face: "Geometry") -> bool:
    """Whether all edges run level or upright."""
    import shapely

    rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(face)]
    return all(
        np.abs(np.diff(ring, axis=0)).min(axis=1).max() <= 2 * _SAME_LINE_M for ring in rings
    )


def _convex(points: Array) -> Array:
    """(K, 2) corners of a convex hull in the plane, counter-clockwise."""
    import shapely

    hull = shapely.convex_hull(shapely.multipoints(points))
    ring = np.asarray(shapely.get_coordinates(shapely.normalize(hull)))[:-1]
    x, y = ring.T
    clockwise = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) < 0.0
    return ring[::-1] if clockwise else ring


def _rectangles(face: "Geometry") -> Iterator[tuple[float, float, float, float]]:
    """(left, right, bottom, top) of what is left between holes; the ends reach to infinity."""
    import shapely

    low, bottom, high, top = shapely.bounds(face).tolist()
    corners = np.unique(np.round(shapely.get_coordinates(face)[:, 0], 6))
    spans: list[tuple[float, float, tuple[tuple[float, float], ...]]] = []
    for left, right in pairwise(corners.tolist()):
        if right - left < 2 * _SAME_LINE_M:
            continue
        x = 0.5 * (left + right)
        crossed = shapely.intersection(face, shapely.linestrings([[x, bottom], [x, top]]))
        bounds = shapely.bounds(shapely.get_parts(crossed)).tolist()
        upright = tuple(
            sorted((part[1], part[3]) for part in bounds if part[3] - part[1] > _SAME_LINE_M)
        )
        if spans and spans[-1][2] == upright:
            spans[-1] = (spans[-1][0], right, upright)
        else:
            spans.append((left, right, upright))
    for left, right, upright in spans:
        ends = (-np.inf if left <= low else left, np.inf if right >= high else right)
        yield from ((*ends, *levels) for levels in upright)


def slab_hull(mesh: TriangleMesh) -> TriangleMesh:
    """The convex hull of a level slab, exactly: a prism over the hull of its plan."""
    levels = mesh.points[:, 2]
    return _solid(_convex(mesh.points[:, :2]), float(levels.min()), float(levels.max()))


def _prism(
    outline: Array, left: float, right: float, bottom: float, top: float
) -> TriangleMesh | None:
    """The outline between two uprights and two levels; None where nothing is left of it."""
    kept = _distinct(_cut(_cut(outline, left, 1.0), right, -1.0))
    return _solid(kept, bottom, top) if len(kept) >= 3 else None


def _solid(ring: Array, bottom: float, top: float) -> TriangleMesh:
    """A prism over a convex, counter-clockwise (K, 2) ring."""
    n = len(ring)
    points = np.column_stack([np.tile(ring, (2, 1)), np.repeat([bottom, top], n)])
    i = np.arange(n)
    j = (i + 1) % n
    fan = np.stack([np.zeros(n - 2, np.int64), i[1:-1], i[2:]], axis=1)
    sides = [np.stack([i, j, j + n], axis=1), np.stack([i, j + n, i + n], axis=1)]
    rows = np.concatenate([fan[:, ::-1], fan + n, *sides]).astype(np.int32)
    return TriangleMesh(points, rows, np.arange(len(rows), dtype=np.int32))


def _turned(mesh: TriangleMesh, frame: Array) -> TriangleMesh:
    return TriangleMesh(mesh.points @ frame.T, mesh.triangles, mesh.faces)


def _distinct(ring: Array) -> Array:
    """A ring without corners that coincide: a cut beside a corner makes another one there."""
    gaps = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
    return np.asarray(ring[gaps > _SAME_LINE_M])


def _cut(ring: Array, at: float, side: float) -> Array:
    """The part of a convex ring where ``side * (x - at)`` is not negative."""
    if not np.isfinite(at):
        return ring
    kept: list[Array] = []
    for here, following in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        a, b = side * (here[0] - at), side * (following[0] - at)
        if a >= 0.0:
            kept.append(here)
        if a * b < 0.0:
            kept.append(here + (following - here) * a / (a - b))
    return np.array(kept).reshape(-1, 2)
